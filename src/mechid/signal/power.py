"""Power of a record over frequency and time: one-sided densities, cumulative and windowed RMS."""

from __future__ import annotations

import numpy as np

from mechid.arrays import FloatArray

JUMP = 10.0
"""Least difference of a jump's sample to both neighbours, relative to the median difference of adjacent samples."""


def power_density(y: FloatArray, sample_rate: float) -> tuple[FloatArray, FloatArray]:
    """Return the one-sided power spectral density by the boxcar periodogram.

    Its sum times the frequency step is the mean square of `y` (Parseval), lines and mean included.

    Parameters
    ----------
    y : (N,)
        Samples in any unit.
    sample_rate : float
        Hz.

    Returns
    -------
    frequency : (N // 2 + 1,) Hz
    density : (N // 2 + 1,) unit of `y` squared per Hz
    """
    power = np.abs(np.fft.rfft(y)) ** 2 / (y.size * sample_rate)
    # All bins except mean and Nyquist have a mirror image.
    power[1 : -1 if y.size % 2 == 0 else None] *= 2.0
    frequency = np.arange(power.size) * (sample_rate / y.size)
    return frequency.astype(np.float64), np.asarray(power, dtype=np.float64)


def cumulative_rms(frequency: FloatArray, density: FloatArray) -> FloatArray:
    """Return the RMS of all components at or below each frequency, (n,), without the mean.

    Parameters
    ----------
    frequency : (n,)
        Hz, from 0, in equal steps.
    density : (n,)
        One-sided, unit squared per Hz.
    """
    power = density * (frequency[1] - frequency[0])
    power[0] = 0.0
    return np.asarray(np.sqrt(np.cumsum(power)), dtype=np.float64)


def windowed_rms(y: FloatArray, sample_rate: float, window_s: float) -> FloatArray:
    """Return the RMS about the window's mean in all windows of n samples, (N - n + 1,).

    It shows the course of a sweep over time. The k-th window begins at sample k.

    Parameters
    ----------
    y : (N,)
    sample_rate : float
        Hz.
    window_s : float
        Length of the window in s, limited to between one sample and all of them.
    """
    n = min(max(round(window_s * sample_rate), 1), y.size)
    # Differences of cumulative sums cost O(N) for any window; the mean is removed first to keep their digits.
    centred = y - y.mean()
    sums, squares = (np.concatenate([[0.0], np.cumsum(part)]) for part in (centred, centred**2))
    mean, square = (sums[n:] - sums[:-n]) / n, (squares[n:] - squares[:-n]) / n
    return np.asarray(np.sqrt(np.maximum(square - mean**2, 0.0)), dtype=np.float64)


def periodic_power(y: FloatArray) -> float:
    """Return the mean square about the mean of interval-averaged samples over whole periods of a signal with jumps.

    If the signal jumps from a to b within a sample's interval, the sample is the mean m over the interval. Its square
    is then too small by (m - a)(b - m), where a and b are taken from the neighbours.

    Parameters
    ----------
    y : (N,)

    Examples
    --------
    >>> y = np.array([0.0] * 10 + [0.25] + [1.0] * 10 + [0.75])
    >>> round(periodic_power(y), 12), round(float(np.var(y)), 12)
    (0.25, 0.232954545455)
    """
    step = np.diff(y, prepend=y[-1])
    after = np.roll(step, -1)
    least = JUMP * float(np.median(np.abs(step)))
    jumps = (np.abs(step) > least) & (np.abs(after) > least) & (step * after > 0.0)
    return float(np.var(y) + np.sum(step[jumps] * after[jumps]) / y.size)
