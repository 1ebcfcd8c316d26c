"""First moments of a record's motion: window, robust cost, and start states of records that begin in motion."""

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
from mechid.identification.search.rest import commanded_first_step, motion_start, rest_window, subtract_hum
from mechid.identification.search.settings import SEARCH
from mechid.kernel.start import off_rest
from mechid.simulation.simulator import Run, Simulator, TimeBase
from mechid.simulation.start import states_in
from mechid.simulation.trajectory import SimulationOutcome


def first_window(target: Target) -> Window:
    """Return the first window that is compared, in samples.

    The window begins after the burn-in. If it would end before the record has moved for 15 ms, it begins 5 ms before
    the motion instead, because a rest costs the same at every start. The motion is taken from the channels,
    independently of where the command is declared to begin. If the channels are never at rest, as under hum, or show no
    motion, the first commanded step is used.
    """
    rate, first = target.base.sample_rate_hz, target.burn_in
    moves = motion_start(target, SEARCH.longest_rest_s)
    if not _is_late(target, moves):
        step = commanded_first_step(target)
        moves = step if _is_late(target, step) and _is_quiet_before(target, step) else first
    if moves > first:
        first = moves - round(SEARCH.lead_s * rate)
    return first, min(target.samples, first + round(SEARCH.first_window_s * rate))


def _is_late(target: Target, moves: int) -> bool:
    """Tell whether a motion begins too late for the window after the burn-in, and early enough to be simulated."""
    rest_s = (moves - target.burn_in) / target.base.sample_rate_hz
    return SEARCH.first_window_s - SEARCH.floor_s < rest_s <= SEARCH.longest_rest_s and moves < target.samples


def _is_quiet_before(target: Target, step: int) -> bool:
    """Tell whether all channels move much less in the window after the burn-in than in the one from a step on."""
    size = round(SEARCH.first_window_s * target.base.sample_rate_hz)
    return all(
        np.var(c.measured[target.burn_in : target.burn_in + size])
        < SEARCH.quiet * np.var(c.measured[step : step + size])
        for c in target.channels
    )


def first_samples(target: Target) -> int:
    """Return the number of samples in the first window."""
    first, stop = first_window(target)
    return stop - first


def first_residual(problem: Problem, target: Target, q: FloatArray) -> FloatArray:
    """Return the residuals of a target's channels over the first window, in sigmas, with medians removed."""
    return np.asarray(first_residuals(problem.model, target, [q])[0])


def first_residuals(
    model: Model, target: Target, points: Sequence[FloatArray], window: Window | None = None
) -> FloatArray:
    """Return the residuals of `first_residual` at several points, one row each, over the first or another window."""
    window, rest = window or first_window(target), rest_window(target)
    rooms = misfit_series_of(model, target, points, window)
    each = []
    for channel, series in zip(target.channels, zip(*rooms, strict=True), strict=True):
        rows = np.stack([room[:] for room in series])
        subtract_hum(channel, rest, window, rows)
        rows /= channel.sigma
        if channel.linear:
            rows -= np.median(rows, axis=1, keepdims=True)
        # Rejected samples are zeroed last, because removing hum and median would make them count again.
        rows[:, channel.rejected_within(window)] = 0.0
        each.append(rows)
    return each[0] if len(each) == 1 else np.concatenate(each, axis=1)


def robust_cost(residual: FloatArray) -> float:
    """Return the soft-L1 cost with scale `SEARCH.robust_sigmas`; inf if the simulation failed."""
    return float(robust_costs(residual[np.newaxis])[0])


def robust_costs(residuals: FloatArray) -> FloatArray:
    """Return the soft-L1 cost of each row."""
    with np.errstate(over="ignore", invalid="ignore"):  # an overflow counts as a failed simulation
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
    """Return a point at which records that begin in motion start from the state to which the model's run-up leads.

    Records that begin at rest, records outside `targets`, and states named in `known` stay unchanged. Each further try
    starts one electrical period earlier in the motion; the try that best explains the record's first moments is used.
    """
    for target in problem.targets if targets is None else targets:
        found = [
            _with_start_states(problem, q, target, values, known)
            for values in _run_up_states(problem, target, q, tries)
        ]
        if len(found) > 1:
            costs = [robust_cost(first_residual(problem, target, point)) for point in found]
            q = found[int(np.argmin(costs))]
        elif found:
            q = found[0]
    return q


def continued_start(problem: Problem, q: FloatArray, target: Target) -> FloatArray | None:
    """Return a point at which a target starts from the final state of the stretch before it; None if there is none."""
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
    return _with_start_states(problem, q, target, values, ())


def _leads_to(one: Target, other: Target) -> bool:
    """Tell whether one target ends where the other begins, under the same command."""
    same = one.command.rate == other.command.rate and one.command.start_angle_deg == other.command.start_angle_deg
    gap = other.base.start_s - one.base.start_s - one.samples * one.base.interval_s
    return (
        same and abs(gap) < 0.5 * one.base.interval_s and one.name.rpartition("_")[0] == other.name.rpartition("_")[0]
    )


def _with_start_states(
    problem: Problem, q: FloatArray, target: Target, values: Mapping[str, float], known: Container[str]
) -> FloatArray:
    """Return a point with start states of a target replaced, except the known ones."""
    names = {
        p.name: values[key_in_record(p.name)] for p in target.free_parameters if is_of_start(p) and p.name not in known
    }
    at = problem.coordinates
    own = zip(at.record_parameter_names, at.of_records(q), strict=True)
    moved = np.concatenate([at.of_mechanism(q), [names.get(name, v) for name, v in own]])
    return np.asarray(at.clip(moved))


def _run_up_states(problem: Problem, target: Target, q: FloatArray, tries: int) -> list[dict[str, float]]:
    """Return start states of a target that the model's run-up leads to, the last first.

    The list is empty if the target begins at rest.
    """
    command, step_s = target.command, 1.0 / max(abs(target.command.start_rate), 1e-9)
    if command.begun_s <= 0.0 or not any(is_of_start(p) for p in target.free_parameters):
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
TakeRounds = Callable[[Problem, FloatArray, Horizons], tuple[FloatArray, Horizons]]
"""Function that grows horizons from a point, and returns the new point and its horizons."""


LiftToAll = Callable[[FloatArray, Horizons], tuple[FloatArray, Horizons]]
"""Function that maps a point and horizons of a part of the records to all records."""


def grow_from_records_at_rest(
    problem: Problem,
    q: FloatArray,
    least: Horizons,
    grow_part: Callable[[Problem, FloatArray, LiftToAll], tuple[FloatArray, Horizons]],
    rounds: TakeRounds,
) -> FloatArray:
    """Grow the records that begin at rest, then adapt the start state alone of each record that begins in motion.

    With a free start state, nearly any mechanism explains the first moments. In a short gate, mechanism and start state
    would go astray together.

    Parameters
    ----------
    problem : Problem
    q : (n,)
    least : dict of str to int
        Least horizon of each record, samples.
    grow_part : callable
        Grows the horizons of a part of the records from a point of that part.
    rounds : callable
        As for `restart_records`.
    """
    part = problem.rest_problem
    names = [t.name for t in part.targets]
    own = part.coordinates.records_point(problem.coordinates.values(q))

    def lift_to_all(moved: FloatArray, gates: Horizons) -> tuple[FloatArray, Horizons]:
        return problem.point_from(part, moved, q), {**least, **gates}

    found = grow_part(part, np.concatenate([part.coordinates.of_mechanism(q), own]), lift_to_all)
    moving = [t for t in problem.targets if t.name not in names]
    return restart_records(problem, *lift_to_all(*found), rounds, targets=moving)


def restart_records(
    problem: Problem, q: FloatArray, gates: Horizons, rounds: TakeRounds, *, targets: Sequence[Target]
) -> FloatArray:
    """Return a point at which other start states let the model follow some records further; `q` if there is none.

    Parameters
    ----------
    problem : Problem
    q : (n,)
    gates : dict of str to int
        Samples of each record that the model follows.
    rounds : callable
        Grows the horizon of one record with only its start state free.
    targets : sequence of Target
        Records that are not followed to their ends, in the order in which they are tried.
    """
    for target in targets:
        for point in (
            continued_start(problem, q, target),
            run_up(problem, q, targets=[target], tries=SEARCH.run_up_tries),
        ):
            if point is None or np.array_equal(point, q):
                continue
            moved, reached = _grow_start_alone(problem, target, point, gates[target.name], rounds)
            if reached > gates[target.name]:
                q = moved
                break
    return q


def _grow_start_alone(
    problem: Problem, target: Target, q: FloatArray, gate: int, rounds: TakeRounds
) -> tuple[FloatArray, int]:
    """Grow the horizon of one record with only its start state free; return the point and the horizon."""
    alone = problem.restrict_to([target.name]).fix_mechanism(q)
    own = [n for n, name in enumerate(problem.coordinates.names) if name in alone.coordinates.record_parameter_names]
    at, gates = rounds(alone, q[own], {target.name: gate})
    moved = q.copy()
    moved[own] = at
    return moved, gates[target.name]
