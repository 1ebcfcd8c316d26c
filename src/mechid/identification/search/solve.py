"""The trust-region solver on reduced triangles, and what a point where it stopped says of its parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle
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
    first, at = norm(inside), (start, _lost(start.size))
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


def _lost(size: int) -> Triangle:
    return Triangle(np.inf, np.full((1 + size, size), np.nan), 0)


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
