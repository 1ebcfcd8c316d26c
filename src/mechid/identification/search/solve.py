"""The trust-region solver on reduced triangles, and the search along a cliff where it refuses every step.

A small parameter change may flip a stick-slip event. The cost inside a branch (an order of stick and slip) is smooth,
and the derivatives promise an optimum that lies in another branch, whose cost is higher. The best point of this branch
lies then on its edge, seldom where the solver came to it.
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
"""The norm of a failed simulation: no other comes near, and SciPy can still square and divide it."""


class _AtOptimumError(Exception):
    """Ends the solver's run, which has no other way to be told that a point is good enough."""


@dataclass(frozen=True)
class Solution:
    """A point, its triangle, and whether the solver called it converged."""

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

    A failed simulation is infinitely bad; the solver steps back, and where it fails at `q` itself it stays
    there. `progress` is told every cost, `accepted` every point that is better than all before.
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

    The residual is (norm, 0, ..., 0) in the triangle's basis: trial points need no Jacobian, and no matrix
    is decomposed that is larger than the number of coordinates. A fall of the squared norm below `negligible`,
    as the derivatives promise it, is not sought.
    """
    from scipy.optimize import least_squares  # takes 0.1 s to load, and `check` has no use for it

    lower, upper = bounds
    gap = np.where(np.isfinite(upper - lower), 1e-10 * (upper - lower), 0.0)  # a side may be open
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
        if _promised(found, (x - lower > gap) & (upper - x > gap)) < negligible:
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


def _promised(triangle: Triangle, free: BoolArray) -> float:
    """Return by how much the cost falls, in sigmas squared, if it is as its derivatives say."""
    J = triangle.jacobian[:, free]
    Q, R = np.linalg.qr(J / np.maximum(np.linalg.norm(J, axis=0), 1e-300))
    seen = np.abs(np.diag(R)) > 1e-12
    return float(triangle.cost * np.sum(Q[0, seen] ** 2))


def covariance(triangle: Triangle) -> FloatArray:
    """Return the Fisher covariance (J^T J)^-1, (n, n), by singular values of the column-scaled Jacobian.

    Directions that the records do not see get the largest finite variance rather than none.
    """
    J = triangle.jacobian
    scale = np.linalg.norm(J, axis=0)
    scale[scale == 0.0] = 1.0
    _, s, Vt = np.linalg.svd(J / scale, full_matrices=False)
    s = np.maximum(s, 1e-14 * s[0]) if s.size and s[0] > 0.0 else np.ones_like(s)
    half = (Vt.T / s) / scale[:, None]
    return np.asarray(half @ half.T, dtype=np.float64)


def promised_fall(triangle: Triangle, counted: BoolArray) -> float:
    """Return by how much the cost would fall yet if it were as smooth as its derivatives say.

    At an optimum this is nothing. At a cliff, where a touch of zero speed does or does not stick, the solver
    refuses every step and stops all the same.
    """
    U, s, _ = _decomposed(triangle, counted)
    return float(triangle.cost * np.sum(U[0, s > SEARCH.singular * s.max(initial=0.0)] ** 2))


def _decomposed(triangle: Triangle, counted: BoolArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    J = triangle.jacobian[:, counted]
    size = np.linalg.norm(J, axis=0)
    U, s, Vt = np.linalg.svd(J / np.where(size > 0.0, size, 1.0), full_matrices=False)
    return U, s, Vt


@dataclass(frozen=True, eq=False)
class _Part:
    """A record from its window's start on for a while, and what the derivatives say of it."""

    target: Target
    window: tuple[int, int]
    triangle: Triangle

    def excess(self, problem: Problem, step: FloatArray, point: FloatArray) -> float:
        """Return by how much the cost at a point exceeds the promise, in sigmas squared; inf where that fails."""
        over = problem.norm(self.target, point, self.window) ** 2 - _promise(self.triangle, step)
        return over if np.isfinite(over) else np.inf


def along_cliff(
    problem: Problem, q: FloatArray, windows: Windows, rng: np.random.Generator, *, least_gain: float
) -> FloatArray | None:
    """Return a better point of the branch in which `q` is, or None where no draw finds one.

    Draws around the way to the promised optimum are tried in order of the cost that the derivatives at `q`
    promise; the first that keeps its promise well enough to gain `least_gain` (in sigmas squared) is returned.
    It has to keep it at twice the integration steps: what holds at the edge by less than their error, does not.
    The beginning of a record tells most draws that do not, at a fraction of the time.
    """
    fine = replace(problem, substeps=2 * problem.substeps)
    records = _parts(problem, q, windows)
    whole = [parts[-1].triangle for parts in records]
    draws = _draws(problem, q, whole, rng)
    promised = np.array([sum(_promise(t, x - q) for t in whole) for x in draws])
    gains = sum(t.cost for t in whole) - promised - least_gain
    ranked = [i for i in np.argsort(promised, kind="stable") if gains[i] > 0.0]
    for first in range(0, len(ranked), problem.workers):
        batch = ranked[first : first + problem.workers]
        broken = in_threads(
            lambda i: _broken(fine, records, draws[i] - q, draws[i], float(gains[i])), batch, len(batch)
        )
        for i, parts in zip(batch, broken, strict=True):
            if parts is None:
                return np.asarray(draws[i], dtype=np.float64)
            records.remove(parts)
            records.insert(0, parts)  # the record with the cliff tells the next draws soonest
    return None


def _parts(problem: Problem, q: FloatArray, windows: Windows) -> list[list[_Part]]:
    """Return the beginnings of every record, ever longer, up to its whole window; short records first."""
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


def _broken(
    problem: Problem, records: list[list[_Part]], step: FloatArray, point: FloatArray, gain: float
) -> list[_Part] | None:
    """Return the record in which the promise of a `gain` at a point is broken, None where it is kept."""
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
    """Return points around the way from `q` to the promised optimum, (draws, n), within the bounds."""
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


def _promise(triangle: Triangle, step: FloatArray) -> float:
    return float(np.sum((triangle.fun + triangle.jacobian @ step) ** 2))
