"""What a point where the solver stopped leaves in doubt, told from its triangle."""

from __future__ import annotations

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.search.settings import SEARCH


def refused_gain(triangle: Triangle, counted: BoolArray) -> float:
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
