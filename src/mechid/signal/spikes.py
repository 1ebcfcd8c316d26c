"""Detection of spikes: isolated samples far from their neighbours, and outliers of a residual."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import median_filter

from mechid.arrays import FloatArray, IntArray
from mechid.signal import stored_series
from mechid.signal.series import Series, blocks

NEIGHBOURHOOD = 51
"""Number of samples whose median second difference measures the curvature of the smooth signal."""
AROUND = NEIGHBOURHOOD // 2 + 2
"""Number of samples on either side that the decision on a sample depends on."""
SHARP = 8.0
"""Least second difference of a spike, relative to that of its neighbourhood."""


def isolated_spikes(series: Series, sigma: float) -> IntArray:
    """Return the indices of isolated outliers from a smooth signal in noise, ascending.

    A spike of height d has second differences of -2 d, and of d at both neighbours; a step or a line differs.

    Parameters
    ----------
    series : Series of n samples
    sigma : float
        Standard deviation of its noise.
    """
    if series.size < NEIGHBOURHOOD:
        return np.zeros(0, dtype=np.int64)
    found = []
    for part in blocks(series.size):
        first = max(part.start - AROUND, 0)
        # Blocks overlap, so that every sample is judged with its full neighbourhood, and each is reported once.
        spikes = first + _find_isolated(series[first : part.stop + AROUND], sigma)
        found.append(spikes[(spikes >= part.start) & (spikes < part.stop)])
    return np.concatenate(found)


def _find_isolated(series: FloatArray, sigma: float) -> IntArray:
    bend = np.zeros(series.size)
    bend[1:-1] = series[:-2] - 2.0 * series[1:-1] + series[2:]
    # 1.4826 scales a median magnitude to a standard deviation; second differences of white noise have sqrt(6) sigma.
    usual = np.maximum(1.4826 * median_filter(np.abs(bend), NEIGHBOURHOOD, mode="nearest"), np.sqrt(6.0) * sigma)
    sharp = np.abs(bend) > SHARP * usual
    sides = np.zeros(series.size)
    sides[1:-1] = -(bend[:-2] + bend[2:]) / 2.0
    alike = np.abs(sides - 0.5 * bend) < 0.25 * np.abs(bend)
    return np.flatnonzero(sharp & alike).astype(np.int64)


def outliers(residual: Series, limit: float) -> IntArray:
    """Return the indices of samples beyond `limit` robust standard deviations, ascending.

    Parameters
    ----------
    residual : Series of n samples
        With zero mean. The median magnitude of a long series is that of an even selection of its samples.
    limit : float
        In standard deviations, estimated from the median magnitude for Gaussian noise.
    """
    least = limit * 1.4826 * _median_magnitude(residual) + np.finfo(float).tiny
    far = [part.start + np.flatnonzero(np.abs(residual[part]) > least) for part in blocks(residual.size)]
    return np.concatenate(far).astype(np.int64)


def _median_magnitude(series: Series) -> float:
    step = max(-(-series.size // stored_series.MAX_IN_MEMORY), 1)
    some = [series[part.start + -part.start % step : part.stop : step] for part in blocks(series.size)]
    return float(np.median(np.abs(np.concatenate(some)), overwrite_input=True))
