"""Mean, spread and extremes of a series; where it is not long, to the last bit as NumPy has them of an array."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.signal.series import Series, counting
from mechid.signal.stored import pieces_of


def total(series: Series) -> float:
    """Return the sum of all samples of a series."""
    return sum(float(values.sum()) for values in _pieces(series))


def mean(series: Series) -> float:
    """Return the mean of a series, in its unit."""
    return total(series) / series.size


def standard_deviation(series: Series, rejected: IntArray | None = None) -> float:
    """Return the standard deviation of a series about its mean; `rejected`, (s,) ascending, are samples without."""
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
    """Return the least and the largest sample of a series; NaN where any is none."""
    low, high = zip(*((values.min(), values.max()) for values in _pieces(series)), strict=True)
    return float(np.min(low)), float(np.max(high))


def _pieces(series: Series, rejected: IntArray | None = None) -> Iterator[FloatArray]:
    for part in pieces_of(series):
        yield counting(series[part], part, rejected)
