"""Visibility of parameters in the records: parameters without effect, inseparable ones, and chaotic motion."""

from __future__ import annotations

import os
from collections.abc import Iterable

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.campaign import Campaign, CampaignRecord
from mechid.campaign.prediction import simulate, time_base
from mechid.command import MeasuredCommand
from mechid.errors import InputFileError
from mechid.identification.computation.parallel import in_threads
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import Target, target_of
from mechid.identification.search.box import sample_box
from mechid.identification.search.rest import motion_start
from mechid.identification.search.settings import SEARCH
from mechid.identification.uncertainty.settings import VERDICTS
from mechid.parameter import Role
from mechid.plant import chopper, current_limit
from mechid.simulation.trajectory import SimulationOutcome


def chaos_warnings(campaign: Campaign, *, points: int = VERDICTS.points) -> tuple[str, ...]:
    """Return a line with the remedy for each estimated record whose motion is chaotic.

    The test uses the file's own values and, up to `points` in total, points of the box in which the search starts. A
    record is reported where it is chaotic at the file's values or at a quarter of the points.
    """
    targets = tuple(target_of(r) for r in campaign.estimated if r.data is not None)
    if not campaign.mechanism.free or not targets:
        return ()
    problem = Problem(SearchSpace(campaign.mechanism), targets)
    own = problem.coordinates.of_records(problem.start)
    box = [np.concatenate([row, own]) for row in sample_box(problem.space, VERDICTS.points, 0)[:points]]
    looks = [(target, q) for target in targets for q in box]
    apart = in_threads(lambda look: divergence_time_s(problem, *look), looks, os.cpu_count() or 1)
    lines = (_chaos_line(t.name, apart[k * len(box) : (k + 1) * len(box)]) for k, t in enumerate(targets))
    return tuple(filter(None, lines))


def _chaos_line(record: str, times: list[float | None]) -> str:
    """Describe a record by the time in which its runs diverge at each point, the file's own first; may be empty."""
    finite = sorted(t for t in times if t is not None)
    if times[0] is None and 4 * len(finite) < len(times):
        return ""
    at = times[0] or finite[len(finite) // 2]
    where = "at the values of the mechanism file" if times[0] is not None else "in the range where the search starts"
    count = f", and at {len(finite)} of {len(times)} points of the box" if len(times) > 1 else ""
    return f'record "{record}": {where} its motion is chaotic{count}: {describe_chaos(at)}'


def describe_chaos(apart_s: float) -> str:
    """Explain runs that diverge after `apart_s`, with the remedy."""
    return (
        f"parameters displaced by {VERDICTS.displacement:g} of their values change it by more than the noise from "
        f"{apart_s:.3g} s on, so a single fit of the whole record is not reliable; "
        f"write stretch_s = {_round_down(VERDICTS.safe_share * apart_s):g} "
        "to fit it in stretches, each with its own start state"
    )


def divergence_time_s(problem: Problem, target: Target, q: FloatArray) -> float | None:
    """Return the time in s after which runs at `q` and at a tiny displacement differ by more than the noise, for good.

    None where they do not differ within the first 20 s, or meet again: a single stick-slip event that turns out
    differently is not chaos. First all parameters are displaced together. Where that run stays apart, at least one run
    with a single displaced parameter has to stay apart as well.
    """
    size = np.maximum(np.abs(q), np.where(np.isfinite(problem.coordinates.span), 1e-3 * problem.coordinates.span, 1.0))
    # A fixed seed, so that a check of the same campaign repeats.
    signs = np.random.default_rng(0).choice([-1.0, 1.0], q.size)
    together_s = _lasting_divergence_s(problem, target, q, VERDICTS.displacement * size * signs)
    if together_s is None:
        return None
    alone = (VERDICTS.displacement * size * signs * one for one in np.eye(q.size))
    apart = any(_lasting_divergence_s(problem, target, q, step) is not None for step in alone)
    return together_s if apart else None


def _lasting_divergence_s(problem: Problem, target: Target, q: FloatArray, step: FloatArray) -> float | None:
    """Return the time in s at which runs at `q` and `q + step` diverge for good; None where they do not."""
    rate = target.base.sample_rate_hz
    window, stop = max(round(SEARCH.gate_window_s * rate), 1), min(target.samples, round(VERDICTS.longest_s * rate))
    points = q, problem.coordinates.clip(q + step)
    block = window * max(4096 // window, 1)  # whole windows
    runs = [problem.model.run(target, point, stop, block=block).blocks() for point in points]
    outputs = [(problem.model.output(c.quantity), c.sigma) for c in target.channels]
    distances: list[FloatArray] = []
    for here, there in zip(*runs, strict=True):
        off = np.array([(here.y[:, j] - there.y[:, j]) / sigma for j, sigma in outputs])
        whole = off[:, : off.shape[1] // window * window].reshape(len(outputs), -1, window)
        distances.append(np.max(np.mean(whole**2, axis=2), axis=0))
    first = first_diverged_window(np.concatenate(distances) > 1.0)
    return None if first is None else float(first * window / rate)


def first_diverged_window(apart: BoolArray) -> int | None:
    """Return the first window from which two runs stay apart; None where there is none.

    Parameters
    ----------
    apart : (W,) of bool
        Windows in which the runs differ by more than the noise. A motion may die out between two steps, so runs that
        stay apart may agree in some windows.

    Examples
    --------
    >>> met_again = np.arange(1000) == 400
    >>> first_diverged_window(met_again) is None
    True
    >>> first_diverged_window(np.arange(1000) >= 400)
    400
    """
    found = np.flatnonzero(apart)
    if not found.size or found[0] == 0 or apart.size - found[0] < VERDICTS.fewest_windows:  # 0: noise is rounding alone
        return None
    parts = np.array_split(apart[found[0] :], VERDICTS.parts)
    return int(found[0]) if sum(map(np.any, parts)) >= VERDICTS.parts_apart else None


def _round_down(seconds: float) -> float:
    """Return a time rounded down to one digit."""
    digit = 10.0 ** np.floor(np.log10(seconds))
    return float(np.round(np.floor(seconds / digit + 1e-9) * digit, 9))


CURRENTS = tuple(f"current_phase_{x}" for x in "abcd")
SUPPLY_REMEDY = "give it as a number, or add a channel of a phase current"


def refuse_free_supply(campaign: Campaign) -> None:
    """Refuse a free supply voltage beside R, L and k_m, or a free current beside k_m, where no current is measured.

    A known supply of zero is refused too, since the motor cannot move.

    Neither torque nor motion separates them: U -> c U, k_m -> c k_m, R and L -> c^2 leaves both unchanged, and
    makes c times less current.

    Raises
    ------
    InputFileError
        If the campaign has such a supply.
    """
    powers = _supply_powers(campaign)
    free = {q.name for q in campaign.mechanism.free}
    stepped = any(not isinstance(record.command, MeasuredCommand) for record in campaign.estimated)
    for supply in campaign.mechanism.plant.names_with_role(Role.SUPPLY):
        if stepped and supply not in free and campaign.mechanism.value(supply) == 0.0:
            raise InputFileError(
                f"{campaign.mechanism_path}: {supply} is 0, so the motor cannot move; enter the driver's value"
            )
        if free.issuperset(powers) and not _sees_current(campaign):
            raise InputFileError(
                f"{campaign.mechanism_path}: {supply} is free together with {_symbols(campaign, supply)}, which "
                f"torque records cannot separate ({_scaling_text(campaign)} gives the same torque); {SUPPLY_REMEDY}"
            )


def chopper_objection(campaign: Campaign) -> str:
    """Return why no fit follows a chopper switch by switch, empty where the mechanism has none."""
    layout = campaign.mechanism.plant.layout
    if layout is None or chopper.TABLE not in layout.tables:
        return ""
    return (
        f"{chopper.TABLE}: no fit follows a chopper switch by switch, since each value moves all its instants; delete "
        f"the table to estimate with its average, [{current_limit.TABLE}]"
    )


def refuse_unidentifiable(campaign: Campaign) -> None:
    """Refuse a supply that the records cannot separate from the motor, and a chopper switch by switch.

    Raises
    ------
    InputFileError
        If the campaign has one of them.
    """
    refuse_free_supply(campaign)
    if objection := chopper_objection(campaign):
        raise InputFileError(f"{campaign.mechanism_path}: {objection}")


def ambiguity_notes(campaign: Campaign) -> tuple[str, ...]:
    """Describe the ambiguities that records of this kind cannot resolve."""
    frame = (_frame_note(campaign),) if campaign.mechanism.electrical_periods else ()
    supplies = () if _sees_current(campaign) else campaign.mechanism.plant.names_with_role(Role.SUPPLY)
    return (*(_supply_note(campaign, supply) for supply in supplies), *frame)


def _supply_note(campaign: Campaign, supply: str) -> str:
    """Describe how an error of the supply propagates to the estimates."""
    declared = campaign.mechanism.plant.declarations
    enters = [f"{declared[n].meaning} as {_power_text(power)}" for n, power in _other_powers(campaign, supply).items()]
    return (
        f"{supply} is treated as known: without a current or voltage channel an undetected relative error e "
        f"propagates to {_join_words(enters)}."
    )


def _supply_powers(campaign: Campaign) -> dict[str, int]:
    """Return the parameters that scale with the supply, each with its power; tied parameters are left out."""
    mechanism = campaign.mechanism
    declared = mechanism.plant.declarations.items()
    return {n: d.supply_power for n, d in declared if d.supply_power and not mechanism.parameters[n].tied_to}


def _other_powers(campaign: Campaign, supply: str) -> dict[str, int]:
    return {n: power for n, power in _supply_powers(campaign).items() if n != supply}


def _symbols(campaign: Campaign, supply: str) -> str:
    declared = campaign.mechanism.plant.declarations
    return _join_words(declared[name].symbol for name in _other_powers(campaign, supply))


def _scaling_text(campaign: Campaign) -> str:
    symbols = campaign.mechanism.plant.declarations
    return ", ".join(
        f"{symbols[n].symbol} -> c^{power} {symbols[n].symbol}" for n, power in _supply_powers(campaign).items()
    )


def _power_text(power: int) -> str:
    return {1: "e", -1: "-e"}.get(power, f"{power} e")


def _join_words(words: Iterable[str]) -> str:
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def _sees_current(campaign: Campaign) -> bool:
    """Tell whether the campaign estimates from a phase current."""
    return any(match.quantity in CURRENTS for record in campaign.estimated for match in record.estimated)


def _frame_note(campaign: Campaign) -> str:
    """Describe the rotations, reversals and shifts that leave the records unchanged."""
    mechanism = campaign.mechanism
    turning = [h for h in mechanism.harmonics if not h.of_phase]
    turned = " and ".join(f"{h.name} by {-h.orders:g} delta" for h in turning)
    phases = f" with the phases turned, of {turned}" if turning else ""
    step_deg = 360.0 / mechanism.full_steps
    stepped = "" if len(turning) == len(mechanism.harmonics) else "; with harmonics of the torque constant likewise"
    return (
        f"The start angle and direction of record {campaign.records[0].name} fix the frame: the records stay the same "
        f"if all start angles turn by delta{phases} (square waveform: delta in steps of {step_deg:g} deg{stepped}), if "
        "all signs reverse together with those of the phases, and after a shift by whole teeth."
    )


UNSEEN_REMEDY = "no record sees it; add a record that does, or give it as a known number"


def count_sensitivities(campaign: Campaign) -> int:
    """Return the number of sensitivity directions that a fit of this campaign simulates."""
    space = SearchSpace(campaign.mechanism)
    idle = {c.name for c in space.coordinates if space.stands_alone(c)}
    further = (
        sum(q.is_free and q.replaces not in idle for q in (*record.overrides, *record.start))
        for record in campaign.estimated
    )
    return space.size + max(further, default=0)


def start_warnings(campaign: Campaign) -> tuple[str, ...]:
    """Return one line for each failed simulation, each invisible parameter and each chaotic record.

    Invisible parameters are not listed while a record is planned, since that record may show them; `mechid design`
    predicts its information.
    """
    lost = tuple(_failure_line(campaign, record) for record in campaign.records)
    planned = any(record.data is None for record in campaign.estimated)
    unseen = () if planned else tuple(f"{name}: {UNSEEN_REMEDY}" for name in unseen_parameters(campaign))
    return (*filter(None, lost), *unseen, *chaos_warnings(campaign))


def _failure_line(campaign: Campaign, record: CampaignRecord) -> str:
    """Describe the failure of a record that cannot be simulated at the values of the file; else empty."""
    duration_s = min(VERDICTS.look_s, time_base(record, campaign).duration_s)
    trajectory = simulate(campaign, record.name, duration_s=duration_s)
    if trajectory.outcome is SimulationOutcome.COMPLETE:
        return ""
    at = f'record "{record.name}" at {trajectory.lost_from_s:.9g} s'
    return f"{at}, at the values of the mechanism file: {trajectory.outcome.value}"


def unseen_parameters(campaign: Campaign) -> tuple[str, ...]:
    """Return the dotted names of the free parameters that no record of use "estimate" sees."""
    targets = tuple(target_of(record) for record in campaign.estimated if record.data is not None)
    if not campaign.mechanism.free or not targets:
        return ()
    problem = Problem(SearchSpace(campaign.mechanism), targets)
    seen = seen_coordinates(problem)
    visible = {name for name, is_seen in zip(problem.coordinates.names, seen, strict=True) if is_seen}
    visible |= {mean.of for mean in problem.coordinates.means if visible.issuperset(mean.own)}
    partners = {c.partner: c.name for c in problem.space.coordinates if c.partner}
    own = {q.name for record in campaign.estimated for q in record.parameters if q.is_free}
    asked = [q.name for q in campaign.free if q in campaign.mechanism.free or q.name in own]
    return tuple(name for name in asked if partners.get(name, name) not in visible)


def seen_coordinates(problem: Problem, *, seconds: float = VERDICTS.look_s, seed: int = 0) -> BoolArray:
    """Return for each search coordinate whether any record changes with it, (n,).

    Each record is simulated up to `seconds` after its first motion, at the values of the file and, for coordinates
    without effect there, at further points of the box in which the search starts.
    """
    seen = np.zeros(problem.size, dtype=bool)
    own = problem.coordinates.of_records(problem.start)
    for point in sample_box(problem.space, VERDICTS.points, seed):
        q = np.concatenate([point, own])
        for target in problem.targets:
            if seen.all():
                return seen
            seen |= _changed_coordinates(problem, target, q, seconds)
    return seen


def _changed_coordinates(problem: Problem, target: Target, q: FloatArray, seconds: float) -> BoolArray:
    """Return the coordinates that change any simulated sample, (n,)."""
    span = problem.coordinates.span
    moves = motion_start(target)
    rest = moves if moves < target.samples else 0
    stop = min(target.samples, rest + round(seconds * target.base.sample_rate_hz) + 1)
    moved = np.zeros(problem.size, dtype=bool)
    for block in problem.model.run(target, q, stop, jacobian=True).blocks():
        for channel in target.channels:
            j = problem.model.output(channel.quantity)
            finite = np.isfinite(block.y[:, j])
            J = problem.coordinates.block_slopes(target, j, block, block.stop - block.start)[finite]
            moved |= np.any(np.isfinite(J) & (np.abs(J) * (span / channel.sigma) > VERDICTS.rounding_change), axis=0)
    return moved
