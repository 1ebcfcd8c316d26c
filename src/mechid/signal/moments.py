"""Mean, spread and extremes of a series; of an array in memory to the last bit as NumPy has them."""

from __future__ import annotations

import math

import numpy as np

from mechid.signal.series import Series
from mechid.signal.stored import pieces_of


def total(series: Series) -> float:
    """Return the sum of all samples of a series."""
    return sum(float(series[part].sum()) for part in pieces_of(series))


def mean(series: Series) -> float:
    """Return the mean of a series, in its unit."""
    return total(series) / series.size


def standard_deviation(series: Series) -> float:
    """Return the standard deviation of a series about its mean, in its unit."""
    middle = mean(series)
    return math.sqrt(sum(float(np.sum((series[part] - middle) ** 2)) for part in pieces_of(series)) / series.size)


def root_mean_square(series: Series) -> float:
    """Return the root of the mean square of a series, in its unit."""
    return math.sqrt(sum(float(np.sum(series[part] ** 2)) for part in pieces_of(series)) / series.size)


def extremes(series: Series) -> tuple[float, float]:
    """Return the least and the largest sample of a series; NaN where any is none."""
    both = [(series[part].min(), series[part].max()) for part in pieces_of(series)]
    low, high = zip(*both, strict=True)
    return float(np.min(low)), float(np.max(high))
