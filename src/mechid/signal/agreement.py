"""Measures of agreement between prediction and measurement: fit percent and Theil's inequality."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.signal.series import Series, blocks, drop_rejected


@dataclass(frozen=True, kw_only=True)
class TheilInequality:
    """Theil's inequality coefficient, and the proportions of the mean squared error, which sum to one.

    Attributes
    ----------
    coefficient : float
        From 0 (perfect agreement) to 1 (no agreement).
    bias : float
        Proportion due to the difference of the means.
    variance : float
        Proportion due to the difference of the standard deviations.
    covariance : float
        Remaining proportion, due to imperfect correlation.
    """

    coefficient: float
    bias: float
    variance: float
    covariance: float


def theil_inequality(measured: Series, predicted: Series, rejected: IntArray | None = None) -> TheilInequality:
    """Return Theil's inequality coefficient of a prediction [Theil1961]_, as used in [Jategaonkar2006]_.

    Parameters
    ----------
    measured, predicted : Series of N samples
        In the same unit.
    rejected : (s,) of int or None
        Indices of samples to exclude, ascending.

    Returns
    -------
    TheilInequality
        All values are NaN if a sample is not finite; the proportions are NaN if the error is zero.

    References
    ----------
    .. [Theil1961] H. Theil, Economic Forecasts and Policy, 2nd ed., North-Holland 1961.
    .. [Jategaonkar2006] R. V. Jategaonkar, Flight Vehicle System Identification, AIAA 2006.

    Examples
    --------
    >>> theil_inequality(np.array([1.0, 3.0]), np.array([2.0, 4.0])).bias
    1.0
    """
    n = measured.size - (0 if rejected is None else rejected.size)
    # Two passes: moments about the mean lose no digits where the mean is large against the spread.
    means, error = np.zeros(2), 0.0
    for both in _paired_blocks(measured, predicted, rejected):
        means += both.sum(axis=1) / n
        error += float(np.sum((both[0] - both[1]) ** 2)) / n
    covariance = np.zeros((2, 2))
    for both in _paired_blocks(measured, predicted, rejected):
        covariance += (centred := both - means[:, None]) @ centred.T / n
    size = float(np.sqrt(np.diag(covariance) + means**2).sum())
    s_y, s_p = np.sqrt(np.diag(covariance)).tolist()
    return TheilInequality(
        coefficient=_ratio(math.sqrt(error), size),
        bias=_ratio(float(means[0] - means[1]) ** 2, error),
        variance=_ratio((s_y - s_p) ** 2, error),
        covariance=_ratio(2.0 * (s_y * s_p - float(covariance[0, 1])), error),
    )


def fit_percent(measured: Series, residual: Series, rejected: IntArray | None = None) -> float:
    """Return the fit 100 (1 - ||residual|| / ||measured - mean||) in percent.

    Parameters
    ----------
    measured, residual : Series of N samples
        In the same unit.
    rejected : (s,) of int or None
        Indices of samples to exclude, ascending.

    Returns
    -------
    float
        NaN if the measured series is constant.
    """
    n = measured.size - (0 if rejected is None else rejected.size)
    means, squares = np.zeros(2), np.zeros(2)
    for both in _paired_blocks(measured, residual, rejected):
        means[0] += both[0].sum() / n
    for both in _paired_blocks(measured, residual, rejected):
        squares += np.sum((both - means[:, None]) ** 2, axis=1)
    return 100.0 * (1.0 - _ratio(math.sqrt(squares[1]), math.sqrt(squares[0])))


def _paired_blocks(one: Series, other: Series, rejected: IntArray | None) -> Iterator[FloatArray]:
    """Yield blocks, (2, n), of the accepted samples of two series."""
    for part in blocks(one.size):
        yield drop_rejected(np.stack((one[part], other[part])), part, rejected)


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole > 0.0 else math.nan
