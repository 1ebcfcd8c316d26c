"""First moments of a record's motion: their window, their robust cost, and starts of records that begin in motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign.campaign import is_of_start, key_in_record
from mechid.identification.output_error.misfit import Model, Window, misfit_series_of
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.search.rest import commanded_first_step, motion_begins, rest_of, take_hum_away
from mechid.identification.search.settings import SEARCH
from mechid.kernel.start import off_rest
from mechid.simulation.simulator import Run, Simulator, TimeBase
from mechid.simulation.start import states_in
from mechid.simulation.trajectory import SimulationOutcome


def first_window(target: Target) -> Window:
    """Return the first window that counts, in samples.

    It begins behind the burn-in. Where it would end before the record has moved for 15 ms, it begins 5 ms before the
    motion instead: a rest costs the same at every start. The motion is what the channels show, wherever the command is
    said to begin. Where they are never at rest, as under hum, or show nothing, it is the first step commanded.
    """
    rate, first = target.base.sample_rate_hz, target.burn_in
    moves = motion_begins(target, SEARCH.longest_rest_s)
    if not _is_late(target, moves):
        step = commanded_first_step(target)
        moves = step if _is_late(target, step) and _is_quiet_before(target, step) else first
    if moves > first:
        first = moves - round(SEARCH.lead_s * rate)
    return first, min(target.samples, first + round(SEARCH.first_window_s * rate))


def _is_late(target: Target, moves: int) -> bool:
    """Tell whether a motion begins too late for the window behind the burn-in, and early enough to be simulated."""
    rest_s = (moves - target.burn_in) / target.base.sample_rate_hz
    return SEARCH.first_window_s - SEARCH.floor_s < rest_s <= SEARCH.longest_rest_s and moves < target.samples


def _is_quiet_before(target: Target, step: int) -> bool:
    """Tell whether all channels move much less in the window behind the burn-in than in the one from a step on."""
    size = round(SEARCH.first_window_s * target.base.sample_rate_hz)
    return all(
        np.var(c.measured[target.burn_in : target.burn_in + size])
        < SEARCH.quiet * np.var(c.measured[step : step + size])
        for c in target.channels
    )


def first_samples(target: Target) -> int:
    """Return how many samples the first window has."""
    first, stop = first_window(target)
    return stop - first


def first_residual(problem: Problem, target: Target, q: FloatArray) -> FloatArray:
    """Return the residuals of a target's channels over the first window, in sigmas, without their medians."""
    return np.asarray(first_residuals(problem.model, target, [q])[0])


def first_residuals(
    model: Model, target: Target, points: Sequence[FloatArray], window: Window | None = None
) -> FloatArray:
    """Return the same at several points, one at least, over the first window or another: a row each."""
    window, rest = window or first_window(target), rest_of(target)
    rooms = misfit_series_of(model, target, points, window)
    each = []
    for channel, series in zip(target.channels, zip(*rooms, strict=True), strict=True):
        rows = np.stack([room[:] for room in series])
        take_hum_away(channel, rest, window, rows)
        rows /= channel.sigma
        if channel.linear:
            rows -= np.median(rows, axis=1, keepdims=True)
        rows[:, channel.rejected_within(window)] = 0.0
        each.append(rows)
    return each[0] if len(each) == 1 else np.concatenate(each, axis=1)


def robust_cost(residual: FloatArray) -> float:
    """Return the soft-L1 cost at `SEARCH.robust_sigmas`; inf where the simulation failed."""
    return float(robust_costs(residual[np.newaxis])[0])


def robust_costs(residuals: FloatArray) -> FloatArray:
    """Return that of each row."""
    with np.errstate(over="ignore", invalid="ignore"):  # what grew beyond all numbers failed too
        square = (residuals / SEARCH.robust_sigmas) ** 2
        costs = 2.0 * SEARCH.robust_sigmas**2 * np.sum(square / (1.0 + np.sqrt(1.0 + square)), axis=1)
    return np.where(np.isfinite(costs), costs, math.inf)


def run_up(
    problem: Problem,
    q: FloatArray,
    known: Container[str] = (),
    *,
    targets: Sequence[Target] | None = None,
    tries: int = 1,
) -> FloatArray:
    """Return a point whose records in motion begin as the model there does, stepped from before.

    Records that begin at rest, those that are none of `targets`, and states whose names are `known` stay as they are.
    Of several tries, each an electrical period earlier in the motion, the one is taken that explains a record's first
    moments best.
    """
    for target in problem.targets if targets is None else targets:
        found = [_at(problem, q, target, values, known) for values in _begun(problem, target, q, tries)]
        if len(found) > 1:
            costs = [robust_cost(first_residual(problem, target, point)) for point in found]
            q = found[int(np.argmin(costs))]
        elif found:
            q = found[0]
    return q


def continued_start(problem: Problem, q: FloatArray, target: Target) -> FloatArray | None:
    """Return a point whose target begins as the model comes out of the stretch before it; None where there is none."""
    before = next((t for t in problem.targets if _leads_to(t, target)), None)
    if before is None:
        return None
    longer = replace(before, base=replace(before.base, samples=before.samples + 1))
    run = problem.model.run(longer, q, longer.samples)
    for _ in run.blocks():
        pass
    if run.outcome is not SimulationOutcome.COMPLETE:
        return None
    at = target.excitation.initial, target.command.start_angle_rad
    values = off_rest(
        problem.space.mechanism.plant,
        problem.coordinates.kernel(target, q),
        *at,
        _states(run),
    )
    return _at(problem, q, target, values, ())


def _leads_to(one: Target, other: Target) -> bool:
    """Tell whether one target ends where the other begins, under the same command."""
    same = one.command.rate == other.command.rate and one.command.start_angle_deg == other.command.start_angle_deg
    gap = other.base.start_s - one.base.start_s - one.samples * one.base.interval_s
    return (
        same and abs(gap) < 0.5 * one.base.interval_s and one.name.rpartition("_")[0] == other.name.rpartition("_")[0]
    )


def _at(
    problem: Problem, q: FloatArray, target: Target, values: Mapping[str, float], known: Container[str]
) -> FloatArray:
    """Return a point with some states of a target's start."""
    names = {p.name: values[key_in_record(p.name)] for p in target.moved if is_of_start(p) and p.name not in known}
    at = problem.coordinates
    own = zip(at.own_names, at.of_records(q), strict=True)
    moved = np.concatenate([at.of_mechanism(q), [names.get(name, v) for name, v in own]])
    return np.asarray(at.clip(moved))


def _begun(problem: Problem, target: Target, q: FloatArray, tries: int) -> list[dict[str, float]]:
    """Return states of a target's start that the model comes to, the last first; none where it begins at rest."""
    command, step_s = target.command, 1.0 / max(abs(target.command.start_rate), 1e-9)
    if command.begun_s <= 0.0 or not any(is_of_start(p) for p in target.moved):
        return []
    period_s = min(SEARCH.electrical_steps * step_s, command.begun_s)
    first = max(math.ceil(max(SEARCH.run_up_s, SEARCH.run_up_steps * step_s) / period_s), 1)
    periods = min(first + tries - 1, math.floor(command.begun_s / period_s * (1.0 + 1e-9)))
    n = max(math.ceil(period_s * target.base.sample_rate_hz), 1)
    earlier = command.begin_at(command.begun_s - periods * period_s)
    base = TimeBase(n / period_s, periods * n, command.begun_s - (periods * n - 1) * period_s / n)
    plant, p = problem.space.mechanism.plant, problem.coordinates.kernel(target, q)
    simulator = Simulator(plant, earlier, base, capacity=problem.coordinates.lanes)
    run = simulator.run(p, substeps=problem.substeps, block=n, directions=np.zeros((p.size, 0)))
    found: list[dict[str, float]] = []
    for k, _ in enumerate(run.blocks(), 1):
        if k >= min(first, periods) and run.outcome is SimulationOutcome.COMPLETE:
            here = command.begin_at(command.begun_s - (periods - k) * period_s)
            found.insert(
                0,
                off_rest(
                    plant,
                    p,
                    here.excitation(0.0).initial,
                    here.start_angle_rad,
                    _states(run),
                ),
            )
    return found[:tries]


def _states(run: Run) -> FloatArray:
    return states_in(run.simulator.kernel, run.buffers)


Horizons = dict[str, int]
Rounds = Callable[[Problem, FloatArray, Horizons], tuple[FloatArray, Horizons]]
"""Where growth from a point and its horizons leads, and the horizons there."""


Lifted = Callable[[FloatArray, Horizons], tuple[FloatArray, Horizons]]
"""From a point of a part of the records, and horizons there, to all of them."""


def grow_from_records_at_rest(
    problem: Problem,
    q: FloatArray,
    least: Horizons,
    grow_part: Callable[[Problem, FloatArray, Lifted], tuple[FloatArray, Horizons]],
    rounds: Rounds,
) -> FloatArray:
    """Return where the records that begin at rest lead, and from there each that begins in motion by its start alone.

    A start that is free explains the first moments with nearly any mechanism: in a short gate both go astray together.

    Parameters
    ----------
    problem : Problem
    q : (n,)
    least : dict of str to int
        Least horizon of each record, samples.
    grow_part : callable
        Grows the horizons of a part of the records from a point of it.
    rounds : callable
        As of `restart_records`.
    """
    part = problem.anchored
    names = [t.name for t in part.targets]
    own = part.coordinates.records_point(problem.coordinates.values(q))

    def lifted(moved: FloatArray, gates: Horizons) -> tuple[FloatArray, Horizons]:
        return problem.point_from(part, moved, q), {**least, **gates}

    found = grow_part(part, np.concatenate([part.coordinates.of_mechanism(q), own]), lifted)
    moving = [t for t in problem.targets if t.name not in names]
    return restart_records(problem, *lifted(*found), rounds, targets=moving)


def restart_records(
    problem: Problem, q: FloatArray, gates: Horizons, rounds: Rounds, *, targets: Sequence[Target]
) -> FloatArray:
    """Return a point at which records are followed further by another start of theirs; the same one where none is.

    Parameters
    ----------
    problem : Problem
    q : (n,)
    gates : dict of str to int
        How far each is followed, samples.
    rounds : callable
        Grows the horizon of one of them with nothing but its start free.
    targets : sequence of Target
        Those that are not followed to their ends, in the order in which they are tried.
    """
    for target in targets:
        for point in (
            continued_start(problem, q, target),
            run_up(problem, q, targets=[target], tries=SEARCH.run_up_tries),
        ):
            if point is None or np.array_equal(point, q):
                continue
            moved, reached = _by_its_start(problem, target, point, gates[target.name], rounds)
            if reached > gates[target.name]:
                q = moved
                break
    return q


def _by_its_start(problem: Problem, target: Target, q: FloatArray, gate: int, rounds: Rounds) -> tuple[FloatArray, int]:
    """Return a point after the horizon of one record has grown with nothing but its start free, and that horizon."""
    alone = problem.only([target.name]).with_mechanism_held(q)
    own = [n for n, name in enumerate(problem.coordinates.names) if name in alone.coordinates.own_names]
    at, gates = rounds(alone, q[own], {target.name: gate})
    moved = q.copy()
    moved[own] = at
    return moved, gates[target.name]
