"""Spikes: single samples far off their neighbours, and samples far off a residual's spread."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import median_filter

from mechid.arrays import FloatArray, IntArray
from mechid.signal import stored
from mechid.signal.series import Series, blocks

NEIGHBOURHOOD = 51
"""Samples whose median bend tells how much a smooth signal bends there."""
AROUND = NEIGHBOURHOOD // 2 + 2
"""Samples on either side that a verdict on one rests on."""
SHARP = 8.0
"""How many times larger than its neighbourhood's a bend must be to be none of the signal's."""


def isolated_spikes(series: Series, sigma: float) -> IntArray:
    """Return the samples that stand alone off a smooth signal in noise, as numbers, ascending.

    A spike of height d bends a series by -2 d, and by d at both neighbours; a step or a line bends it otherwise.

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
        spikes = first + _isolated(series[first : part.stop + AROUND], sigma)
        found.append(spikes[(spikes >= part.start) & (spikes < part.stop)])
    return np.concatenate(found)


def _isolated(series: FloatArray, sigma: float) -> IntArray:
    bend = np.zeros(series.size)
    bend[1:-1] = series[:-2] - 2.0 * series[1:-1] + series[2:]
    usual = np.maximum(1.4826 * median_filter(np.abs(bend), NEIGHBOURHOOD, mode="nearest"), np.sqrt(6.0) * sigma)
    sharp = np.abs(bend) > SHARP * usual
    sides = np.zeros(series.size)
    sides[1:-1] = -(bend[:-2] + bend[2:]) / 2.0
    alike = np.abs(sides - 0.5 * bend) < 0.25 * np.abs(bend)
    return np.flatnonzero(sharp & alike).astype(np.int64)


def outliers(residual: Series, limit: float) -> IntArray:
    """Return the samples more than `limit` robust standard deviations off, as numbers, ascending.

    Parameters
    ----------
    residual : Series of n samples
        About zero. The median magnitude of one in a file is that of samples that lie evenly over it.
    limit : float
        In standard deviations as the median magnitude tells them for Gaussian noise.
    """
    least = limit * 1.4826 * _median_magnitude(residual) + np.finfo(float).tiny
    far = [part.start + np.flatnonzero(np.abs(residual[part]) > least) for part in blocks(residual.size)]
    return np.concatenate(far).astype(np.int64)


def _median_magnitude(series: Series) -> float:
    step = max(-(-series.size // stored.IN_MEMORY), 1)
    some = [series[part.start + -part.start % step : part.stop : step] for part in blocks(series.size)]
    return float(np.median(np.abs(np.concatenate(some)), overwrite_input=True))
