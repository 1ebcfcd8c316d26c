"""Whether the parts of the records agree at a point, and how far what records have of their own is from none there."""

from __future__ import annotations

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.effects.disturbance import Disturbance
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.uncertainty.covariance import covariances, scores
from mechid.identification.uncertainty.model_error import Comparison


def comparison_at(problem: Problem, q: FloatArray, windows: Windows) -> Comparison:
    """Return the parts of the records at a point, compared over the coordinates that they see and no bound holds."""
    triangle = problem.joint(q, windows)
    counted = ~problem.coordinates.on_bound(q) & (np.linalg.norm(triangle.jacobian, axis=0) > 0.0)
    found = scores(problem, q, windows)
    noise = covariances(triangle, found.variance, counted).robust
    return Comparison(found.parts, triangle.jacobian.T @ triangle.jacobian, noise, counted)


def deviations(problem: Problem, q: FloatArray, windows: Windows, one: Disturbance) -> FloatArray:
    """Return how far each parameter of a disturbance is from where it is none, (k,) in standard errors.

    A value of the mechanism's that is free is none where it is that one's. Those that stand on a bound are left out.
    """
    compared, at = comparison_at(problem, q, windows), problem.coordinates
    counted = np.any(compared.scale != 0.0, axis=1)
    names, slopes = at.value_slopes(q)
    slope, values = dict(zip(names, slopes, strict=True)), at.values(q)
    own = [p for p in one.parameters if counted[at.names.index(p.name)]]
    off = np.array([values[p.name] - values.get(p.replaces, p.value) for p in own])
    maps = np.array([slope[p.name] - slope.get(p.replaces, 0.0) for p in own]).reshape(len(own), problem.size)
    variance, _ = compared.error_if(compared.consistency).variances(maps)
    return np.asarray(np.abs(off) / np.sqrt(np.maximum(variance, 1e-300)), dtype=np.float64)
