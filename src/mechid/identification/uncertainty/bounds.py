"""Parameters on a bound of the mechanism file: whether the records allow it, and what it does to the others' errors.

The unbounded Newton step says how far beyond the bound the records want a coordinate. By less than chance, the bound
is one that they allow, and the truth may lie within: an interval on one side. By more, they contradict it, and what
the bound forces on the other parameters counts as an error of theirs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri

from mechid.arrays import BoolArray, FloatArray
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.uncertainty.settings import ERRORS


@dataclass(frozen=True)
class OnBound:
    """A parameter on its bound, by dotted name.

    Attributes
    ----------
    name : str
    beyond : float
        How far beyond it the records want it, in standard errors.
    interval : (float, float)
        95 % of what they leave within, in the file's unit, the bound first or last. Where they contradict the bound,
        the contradiction counts as a further error.
    """

    name: str
    beyond: float
    interval: tuple[float, float]

    @property
    def contradicted(self) -> bool:
        """Whether that is more than chance."""
        return self.beyond >= ERRORS.contradicted


def newton_step(triangle: Triangle, counted: BoolArray) -> FloatArray:
    """Return the step to where the derivatives put the optimum, (n,), zero where nothing is counted."""
    J = triangle.jacobian[:, counted]
    size = np.linalg.norm(J, axis=0)
    size[size == 0.0] = 1.0
    step = np.zeros(triangle.jacobian.shape[1])
    step[counted] = np.linalg.lstsq(J / size, -triangle.fun, rcond=None)[0] / size
    return step


def on_bounds(
    problem: Problem, q: FloatArray, on: BoolArray, step: FloatArray, covariance: FloatArray
) -> list[OnBound]:
    """Return the parameters on their bounds.

    Parameters
    ----------
    problem : Problem
    q : (n,)
    on : (n,) of bool
        Coordinates on a bound; both of a detent's.
    step : (n,)
        The unbounded Newton step.
    covariance : (n, n)
        Of the coordinates where none is bounded, by noise alone: a bound that excludes the truth makes parts of the
        records disagree, and errors widened by that would hide it.
    """
    found: dict[str, OnBound] = {}
    for j in np.flatnonzero(on):
        name = problem.coordinates.names[j]
        if name in found:  # the sine of a detent whose cosine has said it
            continue
        outward = _outward(problem, q, int(j))
        sigma = math.sqrt(max(float(outward @ covariance @ outward), 0.0))
        away = max(float(outward @ step), 0.0)
        beyond = away / sigma if sigma > 0.0 else 0.0
        # Beyond chance the model is wrong by as much as the records are off: that counts as an error of its own.
        spread = math.hypot(sigma, away) if beyond >= ERRORS.contradicted else sigma
        outside = away / spread if spread > 0.0 else 0.0
        inside = spread * -float(ndtri(0.05 * float(ndtr(-outside)))) - away
        within = problem.coordinates.clip(q - inside * outward)
        ends = [problem.coordinates.values(x)[name] for x in (_at_edge(problem, q, int(j), outward), within)]
        found[name] = OnBound(name, beyond, (min(ends), max(ends)))
    return list(found.values())


def _at_edge(problem: Problem, q: FloatArray, j: int, outward: FloatArray) -> FloatArray:
    """Return a point with a coordinate on its very bound, which the solver only comes near; a detent's as it is."""
    at = problem.coordinates
    if j < at.space.size and at.space.coordinates[j].kind == "cosine":
        return q
    edge = q.copy()
    edge[j] = at.lower[j] if outward[j] < 0.0 else at.upper[j]
    return edge


def _outward(problem: Problem, q: FloatArray, j: int) -> FloatArray:
    """Return the direction in which a coordinate on its bound would leave it, (n,), of length 1."""
    at, out = problem.coordinates, np.zeros(q.size)
    own = at.space.coordinates[j] if j < at.space.size else None
    if own is not None and own.kind == "cosine":
        out[j : j + 2] = q[j : j + 2] / np.linalg.norm(q[j : j + 2])
    else:
        out[j] = -1.0 if q[j] - at.lower[j] < at.upper[j] - q[j] else 1.0
    return out
