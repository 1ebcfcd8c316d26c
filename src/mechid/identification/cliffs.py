"""Cliffs: where a stick/slip hangs by a thread, the solver refuses every step short of the optimum.

The cost inside a branch (an order of stick and slip) is smooth, and the derivatives promise an optimum that
lies in another branch, whose cost is higher. The best point of this branch lies then on its edge, seldom
where the solver came to it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mechid.identification.problem import Problem, Windows
from mechid.identification.reduction import Triangle

FloatArray = NDArray[np.float64]
SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
WIDTHS = (0.1, 0.2, 0.4, 0.8)
DRAWS = 16


def along_cliff(
    problem: Problem, q: FloatArray, windows: Windows, rng: np.random.Generator, *, least_gain: float
) -> FloatArray | None:
    """Return a better point of the branch in which `q` is, or None where no draw finds one.

    Draws around the way to the promised optimum are tried in order of the cost that the derivatives at `q`
    promise; the first that keeps its promise well enough to gain `least_gain` (in sigmas squared) is returned.
    It has to keep it at twice the integration steps: what holds at the edge by less than their error, does not.
    """
    fine = replace(problem, substeps=2 * problem.substeps)
    used = [t for t in problem.targets if t.name in windows]
    triangles = problem.triangles(q, windows)
    cost = np.array([t.cost for t in triangles])
    draws = _draws(problem, q, triangles, rng)
    promised = np.array([[_promise(t, x - q) for t in triangles] for x in draws])
    order = list(np.argsort([windows[t.name][1] for t in used], kind="stable"))
    for i in np.argsort(promised.sum(axis=1), kind="stable"):
        left = float(cost.sum() - promised[i].sum()) - least_gain
        if left <= 0.0:
            return None
        for k in order:
            left -= max(fine.norm(used[k], draws[i], windows[used[k].name]) ** 2 - promised[i, k], 0.0)
            if not left > 0.0:
                order.insert(0, order.pop(order.index(k)))  # the record with the cliff tells the next draw soonest
                break
        else:
            return np.asarray(draws[i], dtype=np.float64)
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
        for share in SHARES
        for width in WIDTHS
        for _ in range(DRAWS)
    ]
    return np.asarray(np.clip(points, problem.lower, problem.upper), dtype=np.float64)


def _promise(triangle: Triangle, step: FloatArray) -> float:
    return float(np.sum((triangle.fun + triangle.jacobian @ step) ** 2))
