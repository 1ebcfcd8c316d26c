"""How far what records have of their own is from none, in the standard errors that hold under model error too."""

from __future__ import annotations

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.disturbance.disturbance import Disturbance
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.uncertainty.covariance import covariances, scores
from mechid.identification.uncertainty.model_error import Comparison


def deviations(problem: Problem, q: FloatArray, windows: Windows, one: Disturbance) -> FloatArray:
    """Return how far each parameter of a disturbance is from where it is none, (k,) in standard errors.

    A value of the mechanism's that is free is none where it is that one's. Those that stand on a bound are left out.
    """
    triangle, at = problem.joint(q, windows), problem.coordinates
    counted = ~at.on_bound(q) & (np.linalg.norm(triangle.jacobian, axis=0) > 0.0)
    found = scores(problem, q, windows)
    noise = covariances(triangle, found.variance, counted).robust
    compared = Comparison(found.parts, triangle.jacobian.T @ triangle.jacobian, noise, counted)
    names, slopes = at.value_slopes(q)
    slope, values = dict(zip(names, slopes, strict=True)), at.values(q)
    own = [p for p in one.parameters if counted[at.names.index(p.name)]]
    off = np.array([values[p.name] - values.get(p.replaces, p.value) for p in own])
    maps = np.array([slope[p.name] - slope.get(p.replaces, 0.0) for p in own]).reshape(len(own), problem.size)
    variance, _ = compared.error_if(compared.consistency).variances(maps)
    return np.asarray(np.abs(off) / np.sqrt(np.maximum(variance, 1e-300)), dtype=np.float64)
