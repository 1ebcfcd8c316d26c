"""Multi-start: short simulations from a box around the catalogue values, of which the best are refined.

The cost surface of an oscillating mechanism is full of local minima, but smooth over the first tens of milliseconds.
Points of a Sobol sequence fill the box of possible catalogue errors (each parameter's declared spread or typical
share). Their robust costs are evaluated on the first window of all records, and the best points are refined on the same
window.
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
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.output_error.digests import identity
from mechid.identification.output_error.misfit import Misfit, Window
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle, absorb, combine_triangles, drop_projected_rows
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
from mechid.identification.search.rest import rest_window, subtract_hum
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import descend
from mechid.kernel.batch.source import SETS

NO_WINDOWS: Windows = MappingProxyType({})


@dataclass(frozen=True)
class Candidate:
    """Point of the multi-start, its robust cost over the first window and, once refined, the Jacobian of that cost."""

    q: FloatArray
    cost: float
    jacobian: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))


def first_energy(target: Target) -> float:
    """Return the energy of a target's first window in sigmas squared, which measures how soon it rejects bad starts."""
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
    """Return the robust cost of `targets` at each point, or inf as soon as it exceeds `cap`.

    The cost covers the first windows, or `windows` by record name. With `align`, the delay of each target is first set,
    for its own cost only, so that the model at each point moves when the record does.
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
    """Return the triangle whose squared norm is the robust cost at `q` and whose gradient is that of the cost.

    Each sample is weighted by its distance. The derivative of the mean stands in for that of the median.
    """
    R = np.zeros((1 + problem.size, 1 + problem.size))
    cost, samples = 0.0, 0
    for target in problem.targets:
        rows = _first_rows(problem, target, q, windows.get(target.name) or first_window(target))
        cost += robust_cost(rows[0])
        rows *= (1.0 + (rows[0] / SEARCH.robust_sigmas) ** 2) ** -0.25
        absorb(R, rows, rows.shape[1])
        samples += rows.shape[1]
    weighted = drop_projected_rows(R, 0, samples)
    jacobian = weighted.jacobian
    # The weights reproduce the gradient of the soft-L1 cost, but not its value: the first row is scaled so that the
    # gradient, the product of norm and first row, survives the exchange of the norm.
    jacobian[0] *= weighted.norm / max(math.sqrt(cost), 1e-300)
    return Triangle(math.sqrt(cost), jacobian, samples)


def _first_rows(problem: Problem, target: Target, q: FloatArray, window: Window) -> FloatArray:
    """Return residual and Jacobian of all channels over a window as rows, (1 + n, samples), in sigmas."""
    rest = rest_window(target)
    whole = np.empty((1 + problem.size, len(target.channels) * (window[1] - window[0])))
    parts = np.split(whole, len(target.channels), axis=1)
    for piece in Misfit(problem.model, target, q, window, jacobian=True):
        here = slice(piece.first - window[0], piece.stop - window[0])
        for k, rows in enumerate(parts):
            piece.residual(k, rows[0, here])
            piece.write_slopes(k, rows[1:, here])
    for channel, rows in zip(target.channels, parts, strict=True):
        subtract_hum(channel, rest, window, rows[:1], rows[1:])
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
        # A point behind the best `SEARCH.starts` so far cannot be refined later, so its simulation may stop early.
        cap = sorted(costs)[SEARCH.starts - 1] + SEARCH.negligible_fall if len(costs) >= SEARCH.starts else math.inf
        tasks = [(some[k : k + SETS], cap) for k in range(0, len(some), SETS)]
        costs += noted.step("starts", [own, seed, first, cap], partial(_map_costs, cost, tasks, workers))
        progress(first + len(some), SEARCH.points)
    drawn = [Candidate(*each) for each in zip(points, costs, strict=True)]
    best = islice(_rank_candidates(drawn), SEARCH.starts)
    return [replace(start, q=_prepare_start(problem, start.q)) for start in best]


def _prepare_start(problem: Problem, q: FloatArray) -> FloatArray:
    """Align the first motions at a sampled point, and set the start states of records that begin in motion."""
    return run_up(problem, align_all_first_motions(problem, q), tries=SEARCH.run_up_tries)


def _map_costs(cost: Callable[[Any], list[float]], tasks: Sequence[Any], workers: int) -> list[float]:
    return list(chain(*map_tasks(cost, tasks, workers)))


def _costs_run_up(problem: Problem, targets: Sequence[Target], task: tuple[Sequence[FloatArray], float]) -> list[float]:
    """Return the run-up cost of `targets` at each point, or inf as soon as it exceeds the cap."""
    points, cap = task
    moving = [target for target in problem.targets if target.begins_in_motion]
    initial = [run_up(problem, q, targets=moving) for q in points] if moving else points
    return capped_costs(problem, initial, targets=targets, cap=cap, align=True)


def _rank_candidates(drawn: Sequence[Candidate]) -> Iterator[Candidate]:
    """Yield candidates in order of cost, without those that cannot be simulated.

    Among negligibly different costs the first drawn comes first, and the catalogue values before all. While nothing
    moves yet, every point explains the records, and the remaining differences are rounding errors that depend on the
    processor.
    """
    left = [c for c in drawn if math.isfinite(c.cost)]
    while left:
        least = min(c.cost for c in left)
        yield left.pop(next(i for i, c in enumerate(left) if c.cost <= least + SEARCH.negligible_fall))


def candidates(
    problem: Problem, starts: Sequence[Candidate], workers: int, journal: Journal | None = None
) -> Iterator[Candidate]:
    """Refine the starts batch by batch, and yield each distinct result once.

    Candidates that explain the first window are yielded as soon as their batch is refined, in order of cost. The others
    are refined further and come last: most of them are still on their way along the valley of coil resistance,
    inductance and torque constant, and growth from an intermediate point fails.
    """
    enough = SEARCH.good_cost * sum(first_samples(t) * len(t.channels) for t in problem.targets)
    noted = journal or Journal()
    seen: list[Candidate] = []
    left: list[Candidate] = []
    for batch in _batches(starts):
        refined = _refine_batch(problem, batch, SEARCH.robust_steps, workers, noted)
        left += [c for c in refined if c.cost > enough]
        yield from _new_candidates([c for c in refined if c.cost <= enough], seen)
    for batch in _batches(list(_rank_candidates(left))):
        yield from _new_candidates(_refine_batch(problem, batch, SEARCH.further_steps, workers, noted), seen)


def best_start(problem: Problem, seed: int, journal: Journal | None = None) -> Candidate | None:
    """Return the best refined start of a problem; None if no start can be simulated."""
    starts = multistart(problem, seed, problem.workers, journal=journal)
    return next(candidates(problem, starts, problem.workers, journal), None)


def _batches(some: Sequence[Candidate]) -> Iterator[Sequence[Candidate]]:
    return (some[first : first + SEARCH.batch] for first in range(0, len(some), SEARCH.batch))


def _refine_batch(
    problem: Problem, starts: Sequence[Candidate], steps: int, workers: int, journal: Journal
) -> list[Candidate]:
    """Refine candidates and return them in order of cost, without those that cannot be simulated."""

    def work() -> list[dict[str, object]]:
        return [dict(vars(c)) for c in map_tasks(partial(_refine_aligned, problem, steps), starts, workers)]

    inputs = [identity(problem), [[c.q, c.cost] for c in starts], steps]
    return list(_rank_candidates([Candidate(**c) for c in journal.step("starts refined", inputs, work)]))


def _refine_aligned(problem: Problem, steps: int, candidate: Candidate) -> Candidate:
    """Refine a candidate, and refine it again if the best delay of a record turns out to be quite different."""
    found = refine(problem, candidate, steps)
    again = realign(problem, found.q)
    if np.array_equal(again, found.q):
        return found
    return min(found, refine(problem, Candidate(again, math.inf), steps), key=lambda one: one.cost)


def _new_candidates(found: Sequence[Candidate], seen: list[Candidate]) -> Iterator[Candidate]:
    """Yield candidates more than a tenth of a sigma from all of `seen`, and add them to it."""
    for candidate in found:
        if all(np.linalg.norm(other.jacobian @ (candidate.q - other.q)) > 0.1 for other in seen):
            seen.append(candidate)
            yield candidate


def cost_with_priors(problem: Problem, q: FloatArray, windows: Windows = NO_WINDOWS, *, priors: bool = True) -> float:
    """Return the robust cost of a point over windows, in sigmas squared, including the priors if `priors` is true."""
    away = problem.coordinates.prior_rows(q)[0] if priors else ()
    return capped_costs(problem, [q], targets=problem.targets, windows=windows)[0] + float(np.sum(np.square(away)))


def refine(
    problem: Problem, candidate: Candidate, steps: int, windows: Windows = NO_WINDOWS, *, priors: bool = False
) -> Candidate:
    """Refine a candidate by robust trust-region steps over the first windows, or over `windows` by record name.

    With `priors`, the cost includes them, so that parameters with a prior at zero stay small.
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
