"""How well a prediction agrees with a measurement: fit percent, and Theil's inequality with its parts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class TheilInequality:
    """Theil's inequality coefficient, and the parts of the mean squared error, which sum to one.

    Attributes
    ----------
    coefficient : float
        From 0, agreement, to 1, none at all.
    bias : float
        Part of the squared error that is a difference of the means.
    variance : float
        Part that is a difference of the standard deviations.
    covariance : float
        What is left: missing correlation.
    """

    coefficient: float
    bias: float
    variance: float
    covariance: float


def theil_inequality(measured: FloatArray, predicted: FloatArray) -> TheilInequality:
    """Return Theil's inequality of a prediction [Theil1961]_, as used in [Jategaonkar2006]_.

    Parameters
    ----------
    measured, predicted : ndarray, shape (N,)
        In the same unit.

    Returns
    -------
    TheilInequality
        NaN throughout where a sample is not finite; the parts are NaN where there is no error at all.

    References
    ----------
    .. [Theil1961] H. Theil, Economic Forecasts and Policy, 2nd ed., North-Holland 1961.
    .. [Jategaonkar2006] R. V. Jategaonkar, Flight Vehicle System Identification, AIAA 2006.

    Examples
    --------
    >>> theil_inequality(np.array([1.0, 3.0]), np.array([2.0, 4.0])).bias
    1.0
    """
    error = float(np.mean((measured - predicted) ** 2))
    size = float(np.sqrt(np.mean(measured**2)) + np.sqrt(np.mean(predicted**2)))
    s_y, s_p = float(np.std(measured)), float(np.std(predicted))
    shared = float(np.mean((measured - measured.mean()) * (predicted - predicted.mean())))
    return TheilInequality(
        coefficient=_ratio(math.sqrt(error), size),
        bias=_ratio(float(np.mean(measured) - np.mean(predicted)) ** 2, error),
        variance=_ratio((s_y - s_p) ** 2, error),
        covariance=_ratio(2.0 * (s_y * s_p - shared), error),
    )


def fit_percent(measured: FloatArray, residual: FloatArray) -> float:
    """Return 100 (1 - ||residual|| / ||measured - mean||), both (N,); NaN where the measured is constant."""
    spread = float(np.linalg.norm(measured - np.mean(measured)))
    return 100.0 * (1.0 - _ratio(float(np.linalg.norm(residual)), spread))


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole > 0.0 else math.nan
