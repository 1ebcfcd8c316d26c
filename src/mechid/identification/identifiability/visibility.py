"""Parameters that the records of a campaign cannot show: ambiguous ones, and those that change no sample.

A parameter that changes no sample, at the start and at points around it, is one of which the campaign
tells nothing, and a search over it would only wander.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.campaign import Campaign, CampaignRecord
from mechid.campaign.prediction import simulate, time_base
from mechid.command import MeasuredCommand
from mechid.errors import InputFileError
from mechid.identification.identifiability.predictability import chaos_warnings
from mechid.identification.identifiability.settings import VERDICTS
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import Target, target_of
from mechid.identification.search.box import sample_box
from mechid.identification.search.first_moments import motion_begins
from mechid.parameter import Role
from mechid.simulation.trajectory import SimulationOutcome

CURRENTS = ("current_phase_a", "current_phase_b")
SUPPLY_REMEDY = "give it as a number, or add a channel of a phase current"


def refuse_free_supply(campaign: Campaign) -> None:
    """Refuse a free supply voltage beside R, L and k_m, or a free current beside k_m, where no current is measured.

    A supply that is known to be none is refused too, since nothing moves then.

    Neither torque nor motion tells them apart: U -> c U, k_m -> c k_m, R and L -> c^2 leaves both as they are, and
    makes c times less current.

    Raises
    ------
    InputFileError
        It is so.
    """
    powers = _powers(campaign)
    free = {q.name for q in campaign.mechanism.free}
    stepped = any(not isinstance(record.command, MeasuredCommand) for record in campaign.estimated)
    for supply in campaign.mechanism.plant.having(Role.SUPPLY):
        if stepped and supply not in free and campaign.mechanism.value(supply) == 0.0:
            raise InputFileError(
                f"{campaign.mechanism_path}: {supply}: found 0, with which nothing moves, so that no record tells any "
                "parameter; write the driver's"
            )
        if free.issuperset(powers) and not _sees_current(campaign):
            raise InputFileError(
                f"{campaign.mechanism_path}: {supply}: free together with {_symbols(campaign, supply)}, which "
                f"torque records cannot separate ({_scaling(campaign)} gives the same torque); {SUPPLY_REMEDY}"
            )


def ambiguity_notes(campaign: Campaign) -> tuple[str, ...]:
    """Say what no record of this kind can tell."""
    frame = (_frame(campaign),) if campaign.mechanism.electrical_periods else ()
    supplies = () if _sees_current(campaign) else campaign.mechanism.plant.having(Role.SUPPLY)
    return (*(_supply(campaign, supply) for supply in supplies), *frame)


def _supply(campaign: Campaign, supply: str) -> str:
    """Say how an error of the supply enters what is estimated."""
    declared = campaign.mechanism.plant.declarations
    enters = [f"{declared[n].meaning} as {_times(power)}" for n, power in _others(campaign, supply).items()]
    return (
        f"{supply} counts as known: without a current or voltage channel a relative error e of it "
        f"enters {_listed(enters)}, unseen."
    )


def _powers(campaign: Campaign) -> dict[str, int]:
    """Return the parameters that follow the supply, each with its power; what is tied follows its own."""
    mechanism = campaign.mechanism
    declared = mechanism.plant.declarations.items()
    return {n: d.supply_power for n, d in declared if d.supply_power and not mechanism.parameters[n].tied_to}


def _others(campaign: Campaign, supply: str) -> dict[str, int]:
    return {n: power for n, power in _powers(campaign).items() if n != supply}


def _symbols(campaign: Campaign, supply: str) -> str:
    declared = campaign.mechanism.plant.declarations
    return _listed(declared[name].symbol for name in _others(campaign, supply))


def _scaling(campaign: Campaign) -> str:
    symbols = campaign.mechanism.plant.declarations
    return ", ".join(f"{symbols[n].symbol} -> c^{power} {symbols[n].symbol}" for n, power in _powers(campaign).items())


def _times(power: int) -> str:
    return {1: "e", -1: "-e"}.get(power, f"{power} e")


def _listed(words: Iterable[str]) -> str:
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def _sees_current(campaign: Campaign) -> bool:
    """Tell whether the campaign estimates from a phase current."""
    return any(match.quantity in CURRENTS for record in campaign.estimated for match in record.estimated)


def _frame(campaign: Campaign) -> str:
    """Say which turns, reversals and moves give the same records."""
    mechanism = campaign.mechanism
    turning = [h for h in mechanism.harmonics if not h.of_phase]
    turned = " and ".join(f"{h.name} by {-h.orders:g} delta" for h in turning)
    phases = f" with the phases turned, of {turned}" if turning else ""
    stepped = "" if len(turning) == len(mechanism.harmonics) else "; with harmonics of the torque constant likewise"
    return (
        f"The start angle and direction of record {campaign.records[0].name} fix the frame: the same records come from "
        f"all start angles turned by delta{phases} (square waveform: delta in steps of 90 deg{stepped}), from all "
        "signs reversed with those of the phases, and from a move by whole teeth."
    )


UNSEEN_REMEDY = "no record sees it; add a record that does, or give it as a known number"


def sensitivities(campaign: Campaign) -> int:
    """Return how many directions of the parameters a fit of this campaign asks for."""
    space = SearchSpace(campaign.mechanism)
    idle = {c.name for c in space.coordinates if space.stands_alone(c)}
    further = (
        sum(q.is_free and q.replaces not in idle for q in (*record.replaced, *record.start))
        for record in campaign.estimated
    )
    return space.size + max(further, default=0)


def start_warnings(campaign: Campaign) -> tuple[str, ...]:
    """Return what the mechanism as written does wrong, what no record sees, which motion is chaotic, one line each.

    While a record is planned, what the others do not see it may; what it would tell `mechid design` says.
    """
    lost = tuple(_lost(campaign, record) for record in campaign.records)
    planned = any(record.data is None for record in campaign.estimated)
    unseen = () if planned else tuple(f"{name}: {UNSEEN_REMEDY}" for name in unseen_parameters(campaign))
    return (*filter(None, lost), *unseen, *chaos_warnings(campaign))


def _lost(campaign: Campaign, record: CampaignRecord) -> str:
    """Return what is to be said of a record that cannot be simulated at the values of the file."""
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
    not seen there, at further points of the box in which the search starts.
    """
    seen = np.zeros(problem.size, dtype=bool)
    own = problem.coordinates.of_records(problem.start)
    for point in sample_box(problem.space, VERDICTS.points, seed):
        q = np.concatenate([point, own])
        for target in problem.targets:
            if seen.all():
                return seen
            seen |= _changes(problem, target, q, seconds)
    return seen


def _changes(problem: Problem, target: Target, q: FloatArray, seconds: float) -> BoolArray:
    """Return which coordinates change any sample that was simulated, (n,)."""
    span = problem.coordinates.span
    moves = motion_begins(target)
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
