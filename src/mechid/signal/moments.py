"""Mean, spread and extremes of a series; for series held in memory, bitwise equal to NumPy's results."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.signal.series import Series, drop_rejected
from mechid.signal.stored_series import pieces_of


def total(series: Series) -> float:
    """Return the sum of all samples of a series."""
    return sum(float(values.sum()) for values in _pieces(series))


def mean(series: Series) -> float:
    """Return the mean of a series, in its unit."""
    return total(series) / series.size


def standard_deviation(series: Series, rejected: IntArray | None = None) -> float:
    """Return the standard deviation of a series; `rejected`, (s,) ascending, are indices of samples to exclude."""
    n = series.size - (0 if rejected is None else rejected.size)
    middle = sum(float(values.sum()) for values in _pieces(series, rejected)) / n
    return math.sqrt(sum(float(np.sum((values - middle) ** 2)) for values in _pieces(series, rejected)) / n)


def root_mean_square(series: Series) -> float:
    """Return the root of the mean square of a series, in its unit."""
    return math.sqrt(sum(float(np.sum(values**2)) for values in _pieces(series)) / series.size)


def norm(series: Series) -> float:
    """Return the root of the sum of squares of a series, in its unit."""
    return math.sqrt(sum(float(values.dot(values)) for values in _pieces(series)))


def extremes(series: Series) -> tuple[float, float]:
    """Return the minimum and the maximum of a series; NaN if any sample is NaN."""
    low, high = zip(*((values.min(), values.max()) for values in _pieces(series)), strict=True)
    return float(np.min(low)), float(np.max(high))


def _pieces(series: Series, rejected: IntArray | None = None) -> Iterator[FloatArray]:
    for part in pieces_of(series):
        yield drop_rejected(series[part], part, rejected)
