"""Power of a record over frequency and over time: one-sided densities, cumulative and windowed RMS."""

from __future__ import annotations

import numpy as np

from mechid.arrays import FloatArray

JUMP = 10.0
"""So many times the median step from sample to sample, on both its sides, a sample holds a jump."""


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
    power[1 : -1 if y.size % 2 == 0 else None] *= 2.0  # but for mean and Nyquist, each has a mirror image
    frequency = np.arange(power.size) * (sample_rate / y.size)
    return frequency.astype(np.float64), np.asarray(power, dtype=np.float64)


def cumulative_rms(frequency: FloatArray, density: FloatArray) -> FloatArray:
    """Return the RMS of all that lies at or below each frequency, (n,), the mean left out.

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
    """Return the RMS about its own mean in every window that fits, (N - n + 1,), n samples a window.

    What a sweep does over time; the k-th window begins at sample k.

    Parameters
    ----------
    y : (N,)
    sample_rate : float
        Hz.
    window_s : float
        s; at least a sample, at most all of them are taken.
    """
    n = min(max(round(window_s * sample_rate), 1), y.size)
    centred = y - y.mean()
    sums, squares = (np.concatenate([[0.0], np.cumsum(part)]) for part in (centred, centred**2))
    mean, square = (sums[n:] - sums[:-n]) / n, (squares[n:] - squares[:-n]) / n
    return np.asarray(np.sqrt(np.maximum(square - mean**2, 0.0)), dtype=np.float64)


def periodic_power(y: FloatArray) -> float:
    """Return the mean square about the mean of samples over whole periods, of which some hold a jump.

    Where the signal jumps from a to b within a sample's interval the sample is the mean over it, m. Its square is then
    too small by (m - a)(b - m), which neighbours tell.

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
