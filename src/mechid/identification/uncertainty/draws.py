"""Tests of an estimate's derivatives: the cost at draws from its covariance, and switches of uncertain order.

A speed that touches zero and either sticks or does not is a discontinuity in the likelihood, often within one standard
error. A covariance from derivatives cannot show it.

A switch grazes its neighbour where the standard deviation of its instant exceeds a tenth of the gap between them. The
derivative of the instant maps the covariance of the estimate to that deviation. Another order of stick and slip then
lies within the errors.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.search.settings import SEARCH
from mechid.identification.uncertainty.settings import ERRORS
from mechid.kernel.batch.source import SETS
from mechid.simulation.block import Block
from mechid.simulation.trajectory import Switching


@dataclass(frozen=True)
class Departure:
    """Departure of the cost from its quadratic: record, first instant in s, number of draws, largest excess.

    `across` names the parameters, by dotted name, whose values separate these draws from the others.
    """

    record: str
    instant_s: float
    draws: int
    excess: float
    across: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Return the record and the instant in words."""
        return f"record {self.record} at {self.instant_s:.6g} s"


@dataclass(frozen=True, eq=False)
class LowerPoint:
    """A point of lower cost than the estimate, (n,), and the difference in sigmas squared."""

    q: FloatArray
    gain: float


@dataclass(frozen=True, eq=False)
class Draws:
    """Result of 30 draws around an estimate: departures from the quadratic cost, and a lower point if there is one."""

    departures: tuple[Departure, ...] = ()
    lower: LowerPoint | None = None


def examine_draws(problem: Problem, q: FloatArray, windows: Windows, covariance: FloatArray, seed: int) -> Draws:
    """Compare the cost at 30 draws from the covariance with the quadratic that standard errors assume.

    Parameters
    ----------
    problem : Problem
    q : (n,)
        The estimate.
    windows : mapping of record to (first, stop)
    covariance : (n, n)
        In search coordinates, zero where nothing is estimated.
    seed : int
    """
    used = [t for t in problem.targets if t.name in windows]
    triangles = problem.triangles(q, windows)
    points = _draw_points(problem, q, covariance, seed)
    cost = _costs(problem, windows, points)
    excess = cost - _predicted_costs(q, triangles, points)
    total = np.abs(excess.sum(axis=1)) > ERRORS.cost_departure
    found = []
    for k, target in enumerate(used):
        off = total & (np.abs(excess[:, k]) > ERRORS.cost_departure / len(used))
        if off.any():
            worst = int(np.argmax(np.abs(excess[:, k]) * off))
            instant = _departure_instant(problem, target, q, points[worst], windows[target.name])
            across = _separating_parameters(problem, points, off, covariance)
            found.append(Departure(target.name, instant, int(off.sum()), float(excess[worst, k]), across))
    return Draws(tuple(found), _lowest_draw(problem, q, points, cost.sum(axis=1), sum(t.cost for t in triangles)))


def _lowest_draw(
    problem: Problem, q: FloatArray, points: FloatArray, costs: FloatArray, here: float
) -> LowerPoint | None:
    """Return the draw of lowest cost, priors included; None where no draw is notably lower than the estimate."""
    gains = here + _prior_cost(problem, q) - costs - [_prior_cost(problem, point) for point in points]
    best = int(np.argmax(gains))
    return LowerPoint(points[best], float(gains[best])) if gains[best] > SEARCH.notable_fall else None


def _prior_cost(problem: Problem, q: FloatArray) -> float:
    away, _ = problem.coordinates.prior_rows(q)
    return float(np.sum(away**2))


def parameters_resting_on(
    problem: Problem, q: FloatArray, windows: Windows, records: Sequence[str], counted: BoolArray
) -> tuple[str, ...]:
    """Return the parameters, by dotted name, whose standard errors depend on the given records."""
    rest: Mapping[str, tuple[int, int]] = {name: w for name, w in windows.items() if name not in records}
    every = _information(problem.triangles(q, windows), problem.size)[np.ix_(counted, counted)]
    other = _information(problem.triangles(q, rest), problem.size)[np.ix_(counted, counted)]
    scale = np.sqrt(np.maximum(np.diag(every), 1e-300))
    every, other = every / np.outer(scale, scale), other / np.outer(scale, scale)
    size = np.diag(np.linalg.pinv(every, hermitian=True))
    # The small diagonal keeps directions that only these records determine: a pseudo-inverse alone would drop them.
    without = np.diag(np.linalg.pinv(other + 1e-12 * np.eye(len(scale)), hermitian=True))
    names = np.array(problem.coordinates.names)[counted]
    return _with_phases(problem, names[without > ERRORS.reliance**2 * size].tolist())


def _separating_parameters(
    problem: Problem, points: FloatArray, off: BoolArray, covariance: FloatArray
) -> tuple[str, ...]:
    """Return the parameters whose mean over the `off` draws differs from that of the others by more than chance."""
    if off.all():
        return ()
    sigma = np.sqrt(np.diag(covariance) * (1.0 / off.sum() + 1.0 / (~off).sum()))
    apart = np.abs(points[off].mean(axis=0) - points[~off].mean(axis=0))
    clearly = (sigma > 0.0) & (apart > ERRORS.means_apart * sigma)
    return _with_phases(problem, np.array(problem.coordinates.names)[clearly].tolist())


def _with_phases(problem: Problem, names: Sequence[str]) -> tuple[str, ...]:
    """Return names, each once, a detent's phase beside its amplitude where both are searched together."""
    partners = {c.name: c.partner for c in problem.space.coordinates if c.partner}
    once = tuple(dict.fromkeys(names))
    return once + tuple(partners[name] for name in once if name in partners)


def _draw_points(problem: Problem, q: FloatArray, covariance: FloatArray, seed: int) -> FloatArray:
    """Return the draws, (draws, n), within the bounds."""
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    # The second number separates these draws from other random streams of the same seed.
    steps = np.random.default_rng((seed, 30)).standard_normal((ERRORS.draws, q.size)) @ root.T
    return np.asarray(problem.coordinates.clip(q + steps), dtype=np.float64)


def _costs(problem: Problem, windows: Windows, points: FloatArray) -> FloatArray:
    """Return the cost of each record at each point, (points, records) in sigmas squared."""
    used = [t for t in problem.targets if t.name in windows]
    # Longest records first, so that no worker starts a long one last.
    names = [t.name for t in sorted(used, key=lambda t: -windows[t.name][1])]
    tasks = [(name, points[k : k + SETS]) for name in names for k in range(0, len(points), SETS)]
    norms = map_tasks(partial(_norms, problem, windows), tasks, problem.workers)
    of_record = dict(zip(names, np.concatenate(norms).reshape(len(used), -1), strict=True))
    found = np.square([of_record[t.name] for t in used]).T
    # A draw that cannot be simulated counts as a huge departure, not as a missing one.
    return np.where(np.isfinite(found), found, 1e12)


def _predicted_costs(q: FloatArray, triangles: Sequence[Triangle], points: FloatArray) -> FloatArray:
    """Return the quadratic prediction from `q` of each record's cost at each point, (points, records)."""
    return np.array([[float(np.sum((t.fun + t.jacobian @ (point - q)) ** 2)) for t in triangles] for point in points])


def _norms(problem: Problem, windows: Windows, task: tuple[str, FloatArray]) -> list[float]:
    """Return ||r|| of one record at some points."""
    name, points = task
    target = next(t for t in problem.targets if t.name == name)
    return problem.norms_at(target, list(points), windows[name])


def _departure_instant(
    problem: Problem, target: Target, q: FloatArray, point: FloatArray, window: tuple[int, int]
) -> float:
    """Return the first instant at which a channel departs from its linear prediction by a sigma; record time, s."""
    with_lanes = problem.model.run(target, q, window[1], jacobian=True)
    there = problem.model.run(target, point, window[1], block=with_lanes.block)
    first, largest = window[0], 0.0
    for here, other in zip(with_lanes.blocks(), there.blocks(), strict=True):
        n = here.stop - max(here.start, window[0])
        if n <= 0:
            continue
        off = np.max([_linear_error(problem, target, c, here, other, point - q, n) for c in target.channels], axis=0)
        # Where no sample departs by a whole sigma, the instant of the largest departure is reported.
        if off.max() > largest:
            first, largest = here.stop - n + int(np.argmax(off > min(1.0, off.max() * 0.999))), float(off.max())
        if largest > 1.0:
            break
    return target.base.start_s + first / target.base.sample_rate_hz


def _linear_error(
    problem: Problem, target: Target, channel: TargetChannel, here: Block, other: Block, step: FloatArray, n: int
) -> FloatArray:
    """Return the distance of a channel from its linear prediction, (n,) in sigmas."""
    j = problem.model.output(channel.quantity)
    expected = here.y[-n:, j] + problem.coordinates.block_slopes(target, j, here, n) @ step
    return np.nan_to_num(np.abs(other.y[-n:, j] - expected) / channel.sigma, nan=np.inf)


def _information(triangles: Sequence[Triangle], size: int) -> FloatArray:
    return np.asarray(sum((t.jacobian.T @ t.jacobian for t in triangles), np.zeros((size, size))), dtype=np.float64)


@dataclass(frozen=True)
class Grazing:
    """The grazing switches of a record: their count, and the worst one with its instant in s of record time.

    `spread_s` is the standard deviation of that instant, `gap_s` the distance to the nearest switch.
    """

    record: str
    count: int
    switches: int
    instant_s: float
    spread_s: float
    gap_s: float

    def __str__(self) -> str:
        """Return the warning for the user."""
        more = f"; this holds for {self.count} of its {self.switches} switches" if self.count > 1 else ""
        return (
            f"record {self.record} at {self.instant_s:.6g} s: the instant of a stick/slip is known only to "
            f"{self.spread_s:.2g} s, and the next switch is {self.gap_s:.2g} s away: their order is not certain{more}"
        )


def grazing_switches(
    problem: Problem,
    q: FloatArray,
    windows: Windows,
    covariance: FloatArray,
    switching: Mapping[str, Switching] = MappingProxyType({}),
) -> list[Grazing]:
    """Return one entry for each record that has grazing switches.

    Parameters
    ----------
    problem : Problem
    q : (n,)
        The estimate.
    windows : mapping of record to (first, stop)
    covariance : (n, n)
        In search coordinates.
    switching : mapping of str to Switching
        Switches at `q` of records that were simulated already; the others are simulated.
    """
    used = (t for t in problem.targets if t.name in windows)
    logs = ((t, switching.get(t.name) or _log_switches(problem, t, q, windows[t.name][1])) for t in used)
    found = (_grazing_of_record(problem, t, q, log, covariance) for t, log in logs)
    return [g for g in found if g]


def _log_switches(problem: Problem, target: Target, q: FloatArray, stop: int) -> Switching:
    run = problem.model.run(target, q, stop, jacobian=True, events=ERRORS.most_switches)
    for _ in run.blocks():
        pass
    return run.switching


def _grazing_of_record(
    problem: Problem, target: Target, q: FloatArray, log: Switching, covariance: FloatArray
) -> Grazing | None:
    moved = problem.space.size
    if log.time.size < 2 or not moved:
        return None
    S = log.sensitivity[:, :moved]
    spread = np.sqrt(np.einsum("ij,jk,ik->i", S, covariance[:moved, :moved], S).clip(min=0.0))
    gaps = np.diff(log.time, prepend=-np.inf, append=np.inf)
    gap = np.minimum(gaps[:-1], gaps[1:])
    share = spread / np.maximum(gap, np.finfo(float).tiny)
    grazes = ~(share <= ERRORS.share_of_gap)
    if not grazes.any():
        return None
    worst = int(np.argmax(np.where(grazes, np.nan_to_num(share, nan=np.inf), 0.0)))
    at = problem.coordinates.timing(target, q).record_s(float(log.time[worst]))
    return Grazing(target.name, int(grazes.sum()), log.time.size, at, float(spread[worst]), float(gap[worst]))
