"""Trust-region solver on reduced triangles, and the search along a cliff where it rejects every step.

A small parameter change may flip a stick-slip event. The cost inside a branch (an order of stick and slip) is smooth,
and the derivatives may predict an optimum that lies in another branch, whose cost is higher. The best point of this
branch then lies on its edge, seldom where the solver reached it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.identification.computation.parallel import in_threads
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.output_error.target import Target
from mechid.identification.search.settings import SEARCH

AT_OPTIMUM = "The derivatives promise no further fall of the cost."
REFUSED = 1e75
"""Norm of a failed simulation: no real norm comes near, and SciPy can still square and divide it."""


class _AtOptimumError(Exception):
    """Ends the solver's run; `least_squares` offers no other way to accept a point as good enough."""


@dataclass(frozen=True)
class Solution:
    """Point, its triangle, and whether the solver reported convergence."""

    q: FloatArray
    triangle: Triangle
    converged: bool
    evaluations: int
    message: str


def solve(
    problem: Problem,
    q: FloatArray,
    windows: Windows,
    *,
    steps: int = 50,
    tolerance: float = 1e-10,
    progress: Callable[[float], None] = lambda cost: None,
    accepted: Callable[[FloatArray], None] = lambda q: None,
) -> Solution:
    """Minimise the joint cost from `q` over the windows, within bounds.

    A failed simulation costs infinitely much, so the solver steps back; if the simulation fails at `q` itself, the
    solver stays there. `progress` receives every cost, `accepted` every point that is better than all before.
    """

    def norm(x: FloatArray) -> float:
        found = problem.total_norm(x, windows)
        progress(found**2)
        return found

    def triangle(x: FloatArray) -> Triangle:
        accepted(x)
        return problem.joint(x, windows)

    bounds = (problem.coordinates.lower, problem.coordinates.upper)
    return descend(norm, triangle, q, bounds, steps=steps, tolerance=tolerance, negligible=SEARCH.negligible_fall)


def descend(
    norm: Callable[[FloatArray], float],
    triangle: Callable[[FloatArray], Triangle],
    start: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
    *,
    steps: int,
    tolerance: float,
    negligible: float = 0.0,
) -> Solution:
    """Minimise `norm` within bounds by SciPy's trust-region reflective method on its `triangle`.

    The residual is (norm, 0, ..., 0) in the triangle's basis. Trial points need no Jacobian, and no decomposed matrix
    is larger than the number of coordinates. The solver stops when the derivatives promise a fall of the squared norm
    below `negligible`.
    """
    from scipy.optimize import least_squares  # takes 0.1 s to load, and `check` has no use for it

    lower, upper = bounds
    gap = np.where(np.isfinite(upper - lower), 1e-10 * (upper - lower), 0.0)  # a bound may be infinite
    # SciPy requires a start strictly inside the bounds.
    inside = np.clip(start, lower + gap, upper - gap)
    first, at = norm(inside), (start, Triangle(np.inf, np.full((1 + start.size, start.size), np.nan), 0))
    calls = 1

    def fun(x: FloatArray) -> FloatArray:
        nonlocal calls
        calls += 1
        found = first if np.array_equal(x, inside) else norm(x)
        out = np.zeros(x.size + 1)
        out[0] = found if np.isfinite(found) else REFUSED
        return out

    def jac(x: FloatArray) -> FloatArray:
        nonlocal at
        found = triangle(x)
        if not np.all(np.isfinite(found.jacobian)):
            raise ArithmeticError("the simulation or its sensitivities failed")
        at = x, found
        if _predicted_free_reduction(found, (x - lower > gap) & (upper - x > gap)) < negligible:
            raise _AtOptimumError
        return found.jacobian

    try:
        result = least_squares(
            fun, inside, jac=jac, bounds=bounds, x_scale="jac", max_nfev=steps, ftol=tolerance, xtol=1e-12, gtol=1e-14
        )
    except _AtOptimumError:
        return Solution(*at, True, calls, AT_OPTIMUM)
    except ArithmeticError as error:
        return Solution(*at, False, calls, str(error))
    return Solution(*at, result.status > 0, calls, str(result.message))


def _predicted_free_reduction(triangle: Triangle, free: BoolArray) -> float:
    """Return the fall of the cost that the derivatives predict, in sigmas squared."""
    J = triangle.jacobian[:, free]
    Q, R = np.linalg.qr(J / np.maximum(np.linalg.norm(J, axis=0), 1e-300))
    seen = np.abs(np.diag(R)) > 1e-12
    return float(triangle.cost * np.sum(Q[0, seen] ** 2))


def covariance(triangle: Triangle) -> FloatArray:
    """Return the Fisher covariance (J^T J)^-1, (n, n), by singular values of the column-scaled Jacobian.

    Directions that the records do not determine get the largest finite variance.
    """
    J = triangle.jacobian
    scale = np.linalg.norm(J, axis=0)
    scale[scale == 0.0] = 1.0
    _, s, Vt = np.linalg.svd(J / scale, full_matrices=False)
    s = np.maximum(s, 1e-14 * s[0]) if s.size and s[0] > 0.0 else np.ones_like(s)
    half = (Vt.T / s) / scale[:, None]
    return np.asarray(half @ half.T, dtype=np.float64)


def predicted_reduction(triangle: Triangle, counted: BoolArray) -> float:
    """Return the further fall of the cost that the derivatives predict, if the cost is smooth.

    It is zero at an optimum. At a cliff, where a brief zero of speed does or does not lead to sticking, the solver
    rejects every step and stops nevertheless.
    """
    U, s, _ = _decompose(triangle, counted)
    return float(triangle.cost * np.sum(U[0, s > SEARCH.singular * s.max(initial=0.0)] ** 2))


def _decompose(triangle: Triangle, counted: BoolArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    J = triangle.jacobian[:, counted]
    size = np.linalg.norm(J, axis=0)
    U, s, Vt = np.linalg.svd(J / np.where(size > 0.0, size, 1.0), full_matrices=False)
    return U, s, Vt


@dataclass(frozen=True, eq=False)
class _Part:
    """Record from its window's start for some time, and its triangle there."""

    target: Target
    window: tuple[int, int]
    triangle: Triangle

    def excess(self, problem: Problem, step: FloatArray, point: FloatArray) -> float:
        """Return the excess of the cost at a point over the predicted cost, in sigmas squared; inf if it fails."""
        over = problem.norm(self.target, point, self.window) ** 2 - _predicted_cost(self.triangle, step)
        return over if np.isfinite(over) else np.inf


def search_cliff(
    problem: Problem, q: FloatArray, windows: Windows, rng: np.random.Generator, *, least_gain: float
) -> FloatArray | None:
    """Return a better point of the branch that contains `q`, or None if no draw finds one.

    Draws around the way to the predicted optimum are tried in order of the cost that the derivatives at `q` predict.
    The first draw that confirms its prediction well enough to gain `least_gain` (in sigmas squared) is returned. It
    must do so with twice the integration steps, because a gain at the edge that is smaller than the integration error
    is not real. The beginning of a record rejects most bad draws in a fraction of the time.
    """
    fine = replace(problem, substeps=2 * problem.substeps)
    records = _parts(problem, q, windows)
    whole = [parts[-1].triangle for parts in records]
    draws = _draws(problem, q, whole, rng)
    predicted = np.array([sum(_predicted_cost(t, x - q) for t in whole) for x in draws])
    gains = sum(t.cost for t in whole) - predicted - least_gain
    ranked = [i for i in np.argsort(predicted, kind="stable") if gains[i] > 0.0]
    for first in range(0, len(ranked), problem.workers):
        batch = ranked[first : first + problem.workers]
        contradicting = in_threads(
            lambda i: _find_contradicting_record(fine, records, draws[i] - q, draws[i], float(gains[i])),
            batch,
            len(batch),
        )
        for i, parts in zip(batch, contradicting, strict=True):
            if parts is None:
                return np.asarray(draws[i], dtype=np.float64)
            records.remove(parts)
            records.insert(0, parts)  # the record with the cliff rejects the next draws soonest
    return None


def _parts(problem: Problem, q: FloatArray, windows: Windows) -> list[list[_Part]]:
    """Return the beginnings of every record in increasing length, up to its whole window; short records first."""
    used = sorted((t for t in problem.targets if t.name in windows), key=lambda t: windows[t.name][1])
    pieces = [
        (t, (start, start + max(round(share * (stop - start)), 1)))
        for t in used
        for start, stop in (windows[t.name],)
        for share in SEARCH.cliff_beginnings
    ]
    triangles = in_threads(lambda piece: problem.triangle(piece[0], q, piece[1]), pieces, problem.workers)
    parts = [_Part(*piece, triangle) for piece, triangle in zip(pieces, triangles, strict=True)]
    return [parts[i : i + len(SEARCH.cliff_beginnings)] for i in range(0, len(parts), len(SEARCH.cliff_beginnings))]


def _find_contradicting_record(
    problem: Problem, records: list[list[_Part]], step: FloatArray, point: FloatArray, gain: float
) -> list[_Part] | None:
    """Return the record whose cost contradicts the prediction of a `gain` at a point, None if none does."""
    left = gain
    for parts in records:
        for part in parts:
            over = part.excess(problem, step, point)
            if over >= gain:
                return parts
        left -= max(over, 0.0)
        if left <= 0.0:
            return parts
    return None


def _draws(problem: Problem, q: FloatArray, triangles: list[Triangle], rng: np.random.Generator) -> FloatArray:
    """Return points around the way from `q` to the predicted optimum, (draws, n), within the bounds."""
    J = np.vstack([t.jacobian for t in triangles])
    r = np.concatenate([t.fun for t in triangles])
    scale = np.linalg.norm(J, axis=0)
    scale[scale == 0.0] = 1.0
    U, s, Vt = np.linalg.svd(J / scale, full_matrices=False)
    s = np.maximum(s, 1e-7 * s[0])
    root = Vt.T / s / scale[:, None]
    step = -root @ (U.T @ r)
    points = [
        q + share * step + width * root @ rng.standard_normal(q.size)
        for share in SEARCH.cliff_shares
        for width in SEARCH.cliff_widths
        for _ in range(SEARCH.cliff_draws)
    ]
    return problem.coordinates.clip(np.asarray(points))


def _predicted_cost(triangle: Triangle, step: FloatArray) -> float:
    return float(np.sum((triangle.fun + triangle.jacobian @ step) ** 2))
