"""The trust-region solver on reduced triangles, and what a converged point says of its parameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from mechid.identification.problem import Problem, Windows
from mechid.identification.reduction import Triangle

FloatArray = NDArray[np.float64]


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
    free: NDArray[np.bool_] | None = None,
    steps: int = 50,
    tolerance: float = 1e-10,
    progress: Callable[[float], None] = lambda cost: None,
) -> Solution:
    """Minimise the joint cost from `q` over the windows, within bounds, moving the `free` coordinates.

    SciPy's trust-region reflective method on the triangle: the residual is (||r||, 0, ..., 0), so that
    trial points need no Jacobian. A failed simulation is infinitely bad; the solver steps back.
    """
    moves = np.ones(problem.size, dtype=bool) if free is None else free
    gap = 1e-10 * (problem.upper - problem.lower)[moves]
    lower, upper = problem.lower[moves], problem.upper[moves]
    start = np.clip(q[moves], lower + gap, upper - gap)
    latest: dict[str, Triangle] = {}

    def whole(x: FloatArray) -> FloatArray:
        full = q.copy()
        full[moves] = x
        return full

    def fun(x: FloatArray) -> FloatArray:
        norm = float(np.linalg.norm(problem.norms(whole(x), windows)))
        out = np.zeros(problem.size + 1)
        out[0] = norm if np.isfinite(norm) else 1e150
        progress(out[0] ** 2)
        return out

    def jac(x: FloatArray) -> FloatArray:
        latest["triangle"] = problem.joint(whole(x), windows)
        return latest["triangle"].jacobian[:, moves]

    result = least_squares(
        fun, start, jac=jac, bounds=(lower, upper), x_scale="jac", max_nfev=steps,
        ftol=tolerance, xtol=1e-12, gtol=1e-14,
    )  # fmt: skip
    return Solution(whole(result.x), latest["triangle"], result.status > 0, int(result.nfev), str(result.message))


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
