"""The multi-start: many short simulations from a box around the catalogue, the best ones refined.

The cost surface of an oscillating mechanism is full of local minima; over the first tens of
milliseconds it is tame. Points of a Sobol sequence fill the box of what a catalogue may be wrong
by (each parameter's declared spread or typical share), robustly costed on the first window of all
records; the best are refined on the same window.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain, islice
from types import MappingProxyType
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.parallel import mapped
from mechid.identification.output_error.identity import identity
from mechid.identification.output_error.misfit import Misfit, Window
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle, absorb, combine_triangles, without_projected_rows
from mechid.identification.output_error.target import Target
from mechid.identification.search.alignment import align_all_first_motions, align_first_motion, realign
from mechid.identification.search.box import sample_box
from mechid.identification.search.first_moments import (
    first_residuals,
    first_samples,
    first_window,
    robust_cost,
    robust_costs,
    run_up,
)
from mechid.identification.search.rest import rest_of, take_hum_away
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import descend
from mechid.kernel.batch.source import SETS

NO_WINDOWS: Windows = MappingProxyType({})


@dataclass(frozen=True)
class Candidate:
    """A point of the multi-start, its robust cost over the first window and, once refined, that cost's Jacobian."""

    q: FloatArray
    cost: float
    jacobian: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))


def first_energy(target: Target) -> float:
    """Return how much a target's first window holds, in sigmas squared: what tells bad starts soonest."""
    n, window = first_samples(target), slice(*first_window(target))
    return sum(float(np.var(c.measured[window])) * n / c.sigma**2 for c in target.channels)


def capped_costs(
    problem: Problem,
    points: Sequence[FloatArray],
    *,
    targets: Sequence[Target],
    cap: float = math.inf,
    windows: Windows = NO_WINDOWS,
    align: bool = False,
) -> list[float]:
    """Return the robust cost of `targets` at each point, or inf as soon as it is known to exceed `cap`.

    It is that of their first windows, or of others by name. With `align` a target's delay is first set, for its own
    cost alone, so that the model at each point moves when the target does.
    """
    total, model = np.zeros(len(points)), problem.model
    for target in targets:
        left = np.flatnonzero(np.isfinite(total)).tolist()
        if left:
            some, window = [points[k] for k in left], windows.get(target.name)
            some = align_first_motion(problem, target, some) if align else some
            total[left] += robust_costs(first_residuals(model, target, some, window))
        total[total > cap] = math.inf
    return total.tolist()


def robust_triangle(problem: Problem, q: FloatArray, windows: Windows = NO_WINDOWS) -> Triangle:
    """Return the triangle whose norm squared is the robust cost at `q` and whose gradient is that cost's.

    Each sample is weighted as its distance deserves, and the median's derivative is taken for the mean's.
    """
    R = np.zeros((1 + problem.size, 1 + problem.size))
    cost, samples = 0.0, 0
    for target in problem.targets:
        rows = _first_rows(problem, target, q, windows.get(target.name) or first_window(target))
        cost += robust_cost(rows[0])
        rows *= (1.0 + (rows[0] / SEARCH.robust_sigmas) ** 2) ** -0.25
        absorb(R, rows, rows.shape[1])
        samples += rows.shape[1]
    weighted = without_projected_rows(R, 0, samples)
    jacobian = weighted.jacobian
    jacobian[0] *= weighted.norm / max(math.sqrt(cost), 1e-300)
    return Triangle(math.sqrt(cost), jacobian, samples)


def _first_rows(problem: Problem, target: Target, q: FloatArray, window: Window) -> FloatArray:
    """Return residual and Jacobian of all channels over a window as rows, (1 + n, samples), in sigmas."""
    rest = rest_of(target)
    whole = np.empty((1 + problem.size, len(target.channels) * (window[1] - window[0])))
    parts = np.split(whole, len(target.channels), axis=1)
    for piece in Misfit(problem.model, target, q, window, jacobian=True):
        here = slice(piece.first - window[0], piece.stop - window[0])
        for k, rows in enumerate(parts):
            piece.residual(k, rows[0, here])
            piece.write_slopes(k, rows[1:, here])
    for channel, rows in zip(target.channels, parts, strict=True):
        take_hum_away(channel, rest, window, rows[:1], rows[1:])
        np.divide(rows, channel.sigma, out=rows)
        if channel.linear:
            rows[0] -= np.median(rows[0])
            rows[1:] -= rows[1:].mean(axis=1, keepdims=True)
        rows[:, channel.rejected_within(window)] = 0.0
    return whole


def multistart(
    problem: Problem,
    seed: int,
    workers: int,
    progress: Callable[[int, int], None] = lambda done, total: None,
    journal: Journal | None = None,
) -> list[Candidate]:
    """Return the best of all sampled points in order of robust cost, not yet refined."""
    noted, own = journal or Journal(), identity(problem)
    mechanism_points = sample_box(problem.space, SEARCH.points, seed)
    tail = problem.coordinates.of_records(problem.start)
    points = [np.concatenate([row, tail]) for row in mechanism_points]
    costs: list[float] = []
    targets = sorted(problem.targets, key=first_energy, reverse=True)
    cost = partial(_costs_run_up, problem, targets)
    for first in range(0, SEARCH.points, SEARCH.chunk):
        some = points[first : first + SEARCH.chunk]
        cap = sorted(costs)[SEARCH.starts - 1] + SEARCH.negligible_fall if len(costs) >= SEARCH.starts else math.inf
        tasks = [(some[k : k + SETS], cap) for k in range(0, len(some), SETS)]
        costs += noted.step("starts", [own, seed, first, cap], partial(_of_all, cost, tasks, workers))
        progress(first + len(some), SEARCH.points)
    drawn = [Candidate(*each) for each in zip(points, costs, strict=True)]
    best = islice(_ranked(drawn), SEARCH.starts)
    return [replace(start, q=_begun(problem, start.q)) for start in best]


def _begun(problem: Problem, q: FloatArray) -> FloatArray:
    """Return a sampled point whose records move when they did, and begin in the motion that they began in."""
    return run_up(problem, align_all_first_motions(problem, q), tries=SEARCH.run_up_tries)


def _of_all(cost: Callable[[Any], list[float]], tasks: Sequence[Any], workers: int) -> list[float]:
    """Return the costs of all tasks, one behind the other."""
    return list(chain(*mapped(cost, tasks, workers)))


def _costs_run_up(problem: Problem, targets: Sequence[Target], task: tuple[Sequence[FloatArray], float]) -> list[float]:
    """Return the cost of `targets` at each of some points, or inf as soon as it is known to exceed a cap."""
    points, cap = task
    moving = [target for target in problem.targets if target.begins_in_motion]
    begun = [run_up(problem, q, targets=moving) for q in points] if moving else points
    return capped_costs(problem, begun, targets=targets, cap=cap, align=True)


def _ranked(drawn: Sequence[Candidate]) -> Iterator[Candidate]:
    """Yield candidates in order of cost; those that cannot be simulated are dropped.

    Where costs differ by nothing the first drawn comes first, the catalogue before all: while nothing moves yet every
    point explains the records, and what is left of the differences is rounding, which another processor has otherwise.
    """
    left = [c for c in drawn if math.isfinite(c.cost)]
    while left:
        least = min(c.cost for c in left)
        yield left.pop(next(i for i, c in enumerate(left) if c.cost <= least + SEARCH.negligible_fall))


def candidates(
    problem: Problem, starts: Sequence[Candidate], workers: int, journal: Journal | None = None
) -> Iterator[Candidate]:
    """Refine the starts batch by batch, and yield each place they come to once.

    Those that explain the first window come as soon as their batch is refined, in order of cost. The others
    come last, refined further: most are on their way along the valley of coil resistance, inductance and
    torque constant, and growth from where they stop on it fails.
    """
    enough = SEARCH.good_cost * sum(first_samples(t) * len(t.channels) for t in problem.targets)
    noted = journal or Journal()
    seen: list[Candidate] = []
    left: list[Candidate] = []
    for batch in _batches(starts):
        refined = _refined(problem, batch, SEARCH.robust_steps, workers, noted)
        left += [c for c in refined if c.cost > enough]
        yield from _unseen([c for c in refined if c.cost <= enough], seen)
    for batch in _batches(list(_ranked(left))):
        yield from _unseen(_refined(problem, batch, SEARCH.further_steps, workers, noted), seen)


def best_start(problem: Problem, seed: int, journal: Journal | None = None) -> Candidate | None:
    """Return the best refined start of a problem; None where no start can be simulated."""
    starts = multistart(problem, seed, problem.workers, journal=journal)
    return next(candidates(problem, starts, problem.workers, journal), None)


def _batches(some: Sequence[Candidate]) -> Iterator[Sequence[Candidate]]:
    return (some[first : first + SEARCH.batch] for first in range(0, len(some), SEARCH.batch))


def _refined(
    problem: Problem, starts: Sequence[Candidate], steps: int, workers: int, journal: Journal
) -> list[Candidate]:
    """Return candidates refined, in order of cost; those that cannot be simulated are dropped."""

    def work() -> list[dict[str, object]]:
        return [dict(vars(c)) for c in mapped(partial(_refine_aligned, problem, steps), starts, workers)]

    inputs = [identity(problem), [[c.q, c.cost] for c in starts], steps]
    return list(_ranked([Candidate(**c) for c in journal.step("starts refined", inputs, work)]))


def _refine_aligned(problem: Problem, steps: int, candidate: Candidate) -> Candidate:
    """Return a candidate refined, and refined again where the delay of a record turns out to be quite another."""
    found = refine(problem, candidate, steps)
    again = realign(problem, found.q)
    if np.array_equal(again, found.q):
        return found
    return min(found, refine(problem, Candidate(again, math.inf), steps), key=lambda one: one.cost)


def _unseen(found: Sequence[Candidate], seen: list[Candidate]) -> Iterator[Candidate]:
    """Yield those that are more than a tenth of a sigma from all `seen`, and count them as seen."""
    for candidate in found:
        if all(np.linalg.norm(other.jacobian @ (candidate.q - other.q)) > 0.1 for other in seen):
            seen.append(candidate)
            yield candidate


def cost_with_priors(problem: Problem, q: FloatArray, windows: Windows = NO_WINDOWS, *, priors: bool = True) -> float:
    """Return the robust cost of a point over windows, in sigmas squared, the priors counted where asked."""
    away = problem.coordinates.prior_rows(q)[0] if priors else ()
    return capped_costs(problem, [q], targets=problem.targets, windows=windows)[0] + float(np.sum(np.square(away)))


def refine(
    problem: Problem, candidate: Candidate, steps: int, windows: Windows = NO_WINDOWS, *, priors: bool = False
) -> Candidate:
    """Return a candidate after some robust trust-region steps over the first windows, or over others by name.

    With `priors` these count too, in the cost as well: what is wanted small stays small.
    """

    def cost_norm(q: FloatArray) -> float:
        return math.sqrt(cost_with_priors(problem, q, windows, priors=priors))

    def triangle(q: FloatArray) -> Triangle:
        alone = robust_triangle(problem, q, windows)
        return combine_triangles([alone, *problem.prior_triangles(q)]) if priors else alone

    found = descend(
        cost_norm,
        triangle,
        candidate.q,
        (problem.coordinates.lower, problem.coordinates.upper),
        steps=steps,
        tolerance=1e-8,
        negligible=SEARCH.negligible_fall,
    )
    return Candidate(found.q, found.triangle.cost, found.triangle.jacobian)
