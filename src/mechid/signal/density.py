"""Power density by Welch's method, and RMS values in third-octave bands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.signal.envelope import peak_groups
from mechid.signal.series import Series
from mechid.signal.window import windowed_density

LONGEST_SEGMENT = 8192
SEGMENTS = 2
"""Least length of a record in segments; with half overlap it then has three of them."""
AT_ONCE = 16
"""Number of segments transformed together."""
THIRD = 10.0**0.1
"""Frequency ratio of adjacent third-octave bands, base ten (IEC 61260-1)."""


def power_density(y: Series, sample_rate: float) -> tuple[FloatArray, FloatArray]:
    """Return the power density by Welch's method, with a Hann window and half overlap.

    Parameters
    ----------
    y : Series of N samples
        In any unit, N at least 16.
    sample_rate : float
        In Hz.

    Returns
    -------
    frequency : ndarray, shape (M,)
        In Hz, from 0 to half the sample rate.
    density : ndarray, shape (M,)
        In the unit squared per Hz; its integral is the variance.
    """
    longest = min(LONGEST_SEGMENT, max(y.size // SEGMENTS, 16))
    length = 2 ** int(np.log2(longest))
    hop = length // 2
    segments = (y.size - hop) // hop
    density = np.zeros(length // 2 + 1)
    for first in range(0, segments, AT_ONCE):
        n = min(AT_ONCE, segments - first)
        # A read-only view on the overlapping segments: only their spectra need memory.
        part = y[first * hop : (first + n + 1) * hop]
        rows = np.lib.stride_tricks.sliding_window_view(part, length)[::hop]
        density += windowed_density(rows, sample_rate).sum(axis=0) / segments
    return np.arange(density.size) * (sample_rate / length), density


def average_in_groups(frequency: FloatArray, density: FloatArray, most: int) -> tuple[FloatArray, FloatArray]:
    """Return the mean density in groups of bins of equal width on a logarithmic axis, without the bin at 0.

    Parameters
    ----------
    frequency, density : ndarray, shape (M,)
        As from `power_density`.
    most : int
        Maximum number of groups, at least 2; no group is narrower than a bin.

    Returns
    -------
    frequency, density : ndarray, shape (G,)
        Mean frequency of each group in Hz, and the density.
    """
    starts = peak_groups(density.size, most)
    sizes = np.diff(starts, append=density.size)
    middle, mean = (np.add.reduceat(values, starts) / sizes for values in (frequency, density))
    return middle, mean


@dataclass(frozen=True, kw_only=True)
class Band:
    """RMS of a signal between two frequencies in Hz; `rms` is in the signal's unit."""

    centre_hz: float
    lower_hz: float
    upper_hz: float
    rms: float


def rms_below(frequency: FloatArray, density: FloatArray, bands: Sequence[Band]) -> float:
    """Return the RMS outside the third-octave bands, that is, below the first one."""
    width = float(frequency[1])
    edges = np.append(np.maximum(frequency - 0.5 * width, 0.0), float(frequency[-1]))
    all_of_it = float(np.sum(density * np.diff(edges)))
    return math.sqrt(max(all_of_it - sum(band.rms**2 for band in bands), 0.0))


def third_octaves(frequency: FloatArray, density: FloatArray) -> tuple[Band, ...]:
    """Return the RMS in third-octave bands, from the first that is as wide as a bin up to half the sample rate.

    Parameters
    ----------
    frequency, density : ndarray, shape (M,)
        As from `power_density`.
    """
    width, end = float(frequency[1]), float(frequency[-1])
    step = np.arange(np.ceil(10.0 * np.log10(width / (THIRD**0.5 - THIRD**-0.5))), 10.0 * np.log10(end))
    centre = 10.0 ** (step / 10.0)
    lower, upper = centre / THIRD**0.5, np.minimum(centre * THIRD**0.5, end)
    edges = np.append(np.maximum(frequency - 0.5 * width, 0.0), end)
    # Interpolating the cumulative power splits the bins at the edges of the bands, so that no power is lost.
    power = np.concatenate([[0.0], np.cumsum(density * np.diff(edges))])
    rms = np.sqrt(np.interp(upper, edges, power) - np.interp(lower, edges, power))
    columns = (column.tolist() for column in (centre, lower, upper, rms))
    return tuple(
        Band(centre_hz=c, lower_hz=low, upper_hz=high, rms=r) for c, low, high, r in zip(*columns, strict=True)
    )
