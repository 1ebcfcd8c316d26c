"""Tests of an estimate's derivatives: the cost at draws from its covariance, and switches whose order is not certain.

A touch of zero speed that does or does not stick is a cliff in the likelihood, often within one standard error.
A covariance from derivatives knows nothing of it.

A switch grazes its neighbour where the standard deviation of its instant, carried over from the covariance of the
estimate by the derivative of the instant, is above a tenth of the gap to it: another order of stick and slip lies
within the errors.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

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


@dataclass(frozen=True)
class Departure:
    """Where the cost of some draws is not the quadratic: record, first instant in s, how many draws, how far.

    `across` are the parameters, by dotted name, that the draws concerned have elsewhere than the others.
    """

    record: str
    instant_s: float
    draws: int
    excess: float
    across: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Say it in a few words."""
        return f"record {self.record} at {self.instant_s:.6g} s"


@dataclass(frozen=True, eq=False)
class LowerPoint:
    """A point of lower cost than the estimate: (n,), and by how much lower, in sigmas squared."""

    q: FloatArray
    gain: float


@dataclass(frozen=True, eq=False)
class Draws:
    """What 30 draws around an estimate show: where the cost departs from the quadratic, and a lower point if any."""

    departures: tuple[Departure, ...] = ()
    lower: LowerPoint | None = None


def examine_draws(problem: Problem, q: FloatArray, windows: Windows, covariance: FloatArray, seed: int) -> Draws:
    """Simulate 30 draws from the covariance, and return what their cost says of the estimate.

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
    points = _drawn(problem, q, covariance, seed)
    cost = _costs(problem, windows, points)
    excess = cost - _promised(q, triangles, points)
    total = np.abs(excess.sum(axis=1)) > ERRORS.cost_departure
    found = []
    for k, target in enumerate(used):
        off = total & (np.abs(excess[:, k]) > ERRORS.cost_departure / len(used))
        if off.any():
            worst = int(np.argmax(np.abs(excess[:, k]) * off))
            instant = _instant(problem, target, q, points[worst], windows[target.name])
            across = _across(problem, points, off, covariance)
            found.append(Departure(target.name, instant, int(off.sum()), float(excess[worst, k]), across))
    return Draws(tuple(found), _lowest(problem, q, points, cost.sum(axis=1), sum(t.cost for t in triangles)))


def _lowest(problem: Problem, q: FloatArray, points: FloatArray, costs: FloatArray, here: float) -> LowerPoint | None:
    """Return the draw of the lowest cost, priors counted; None where none is lower by more than is worth saying."""
    gains = here + _prior_cost(problem, q) - costs - [_prior_cost(problem, point) for point in points]
    best = int(np.argmax(gains))
    return LowerPoint(points[best], float(gains[best])) if gains[best] > SEARCH.notable_fall else None


def _prior_cost(problem: Problem, q: FloatArray) -> float:
    away, _ = problem.coordinates.prior_rows(q)
    return float(np.sum(away**2))


def parameters_resting_on(
    problem: Problem, q: FloatArray, windows: Windows, records: Sequence[str], counted: BoolArray
) -> tuple[str, ...]:
    """Return the parameters, by dotted name, whose standard error rests on some records."""
    rest: Mapping[str, tuple[int, int]] = {name: w for name, w in windows.items() if name not in records}
    every = _information(problem.triangles(q, windows), problem.size)[np.ix_(counted, counted)]
    other = _information(problem.triangles(q, rest), problem.size)[np.ix_(counted, counted)]
    scale = np.sqrt(np.maximum(np.diag(every), 1e-300))
    every, other = every / np.outer(scale, scale), other / np.outer(scale, scale)
    size = np.diag(np.linalg.pinv(every, hermitian=True))
    without = np.diag(np.linalg.pinv(other + 1e-12 * np.eye(len(scale)), hermitian=True))
    names = np.array(problem.coordinates.names)[counted]
    return _with_phases(problem, names[without > ERRORS.told_by**2 * size].tolist())


def _across(problem: Problem, points: FloatArray, off: BoolArray, covariance: FloatArray) -> tuple[str, ...]:
    """Return the parameters whose mean over the draws concerned differs from that of the others by more than chance."""
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


def _drawn(problem: Problem, q: FloatArray, covariance: FloatArray, seed: int) -> FloatArray:
    """Return the draws, (draws, n), within the bounds."""
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    steps = np.random.default_rng((seed, 30)).standard_normal((ERRORS.draws, q.size)) @ root.T
    return np.asarray(problem.coordinates.clip(q + steps), dtype=np.float64)


def _costs(problem: Problem, windows: Windows, points: FloatArray) -> FloatArray:
    """Return the cost of each record at each point, (points, records) in sigmas squared."""
    used = [t for t in problem.targets if t.name in windows]
    names = [t.name for t in sorted(used, key=lambda t: -windows[t.name][1])]
    tasks = [(name, points[k : k + SETS]) for name in names for k in range(0, len(points), SETS)]
    norms = map_tasks(partial(_norms, problem, windows), tasks, problem.workers)
    of_record = dict(zip(names, np.concatenate(norms).reshape(len(used), -1), strict=True))
    found = np.square([of_record[t.name] for t in used]).T
    return np.where(np.isfinite(found), found, 1e12)


def _promised(q: FloatArray, triangles: Sequence[Triangle], points: FloatArray) -> FloatArray:
    """Return what the quadratic at `q` makes of the cost of each record at each point, (points, records)."""
    return np.array([[float(np.sum((t.fun + t.jacobian @ (point - q)) ** 2)) for t in triangles] for point in points])


def _norms(problem: Problem, windows: Windows, task: tuple[str, FloatArray]) -> list[float]:
    """Return ||r|| of a record, by name, at some points."""
    name, points = task
    target = next(t for t in problem.targets if t.name == name)
    return problem.norms_at(target, list(points), windows[name])


def _instant(problem: Problem, target: Target, q: FloatArray, point: FloatArray, window: tuple[int, int]) -> float:
    """Return when any channel at a point first leaves what the derivatives at `q` say, by a sigma; record time, s."""
    with_lanes = problem.model.run(target, q, window[1], jacobian=True)
    there = problem.model.run(target, point, window[1], block=with_lanes.block)
    first, largest = window[0], 0.0
    for here, other in zip(with_lanes.blocks(), there.blocks(), strict=True):
        n = here.stop - max(here.start, window[0])
        if n <= 0:
            continue
        off = np.max([_off(problem, target, c, here, other, point - q, n) for c in target.channels], axis=0)
        if off.max() > largest:
            first, largest = here.stop - n + int(np.argmax(off > min(1.0, off.max() * 0.999))), float(off.max())
        if largest > 1.0:
            break
    return target.base.start_s + first / target.base.sample_rate_hz


def _off(
    problem: Problem, target: Target, channel: TargetChannel, here: Block, other: Block, step: FloatArray, n: int
) -> FloatArray:
    """Return how far a channel is from what its derivatives say, (n,) in sigmas."""
    j = problem.model.output(channel.quantity)
    expected = here.y[-n:, j] + problem.coordinates.block_slopes(target, j, here, n) @ step
    return np.nan_to_num(np.abs(other.y[-n:, j] - expected) / channel.sigma, nan=np.inf)


def _information(triangles: Sequence[Triangle], size: int) -> FloatArray:
    return np.asarray(sum((t.jacobian.T @ t.jacobian for t in triangles), np.zeros((size, size))), dtype=np.float64)


@dataclass(frozen=True)
class Grazing:
    """The grazing switches of a record: how many, and the worst with its instant in s of record time.

    `spread_s` is the standard deviation of the worst one's instant, `gap_s` the distance to its neighbour.
    """

    record: str
    count: int
    of: int
    instant_s: float
    spread_s: float
    gap_s: float

    def __str__(self) -> str:
        """Say it as a warning."""
        more = f"; {self.count} of its {self.of} switches are such" if self.count > 1 else ""
        return (
            f"record {self.record} at {self.instant_s:.6g} s: the instant of a stick/slip is known to "
            f"{self.spread_s:.2g} s only, and the next switch is {self.gap_s:.2g} s away: which comes first is not "
            f"certain{more}"
        )


def grazing_switches(problem: Problem, q: FloatArray, windows: Windows, covariance: FloatArray) -> list[Grazing]:
    """Return the grazing switches of each record that has any.

    Parameters
    ----------
    problem : Problem
    q : (n,)
        The estimate.
    windows : mapping of record to (first, stop)
    covariance : (n, n)
        In search coordinates.
    """
    found = (_of(problem, t, q, windows[t.name][1], covariance) for t in problem.targets if t.name in windows)
    return [g for g in found if g]


def _of(problem: Problem, target: Target, q: FloatArray, stop: int, covariance: FloatArray) -> Grazing | None:
    run = problem.model.run(target, q, stop, jacobian=True, events=ERRORS.most_switches)
    for _ in run.blocks():
        pass
    log, moved = run.switching, problem.space.size
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
