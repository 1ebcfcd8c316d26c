"""Linear propagation: a band from the parameters' covariance, and whose uncertainty makes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

TWO_SIDED_95 = 1.959964


@dataclass(frozen=True)
class Band:
    """A value with its standard error, and each parameter's share of the variance.

    The shares are g_i (C g)_i / (g' C g), g the gradient and C the covariance: they add to 1. With correlated
    parameters one may be negative: it offsets others.
    """

    value: float
    sigma: float
    shares: Mapping[str, float]

    @property
    def ci95(self) -> tuple[float, float]:
        """95 % interval."""
        return self.value - TWO_SIDED_95 * self.sigma, self.value + TWO_SIDED_95 * self.sigma


def propagated(value: float, gradient: FloatArray, covariance: FloatArray, names: Sequence[str]) -> Band:
    """Return the band of a value.

    Parameters
    ----------
    value : float
    gradient : (n,)
        Derivative of the value to each parameter.
    covariance : (n, n)
    names : sequence of str, (n,)
    """
    parts = gradient * (covariance @ gradient)
    variance = float(parts.sum())
    if variance <= 0.0:
        return Band(value, 0.0, dict.fromkeys(names, 0.0))
    return Band(value, float(np.sqrt(variance)), dict(zip(names, (parts / variance).tolist(), strict=True)))
