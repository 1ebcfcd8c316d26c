"""Cliffs of the cost, where a small parameter change flips a stick-slip event and the solver refuses every step.

The cost inside a branch (an order of stick and slip) is smooth, and the derivatives promise an optimum that
lies in another branch, whose cost is higher. The best point of this branch lies then on its edge, seldom
where the solver came to it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.computation.parallel import in_threads
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.output_error.target import Target
from mechid.identification.search.settings import SEARCH


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
