"""Amplitude spectra of a record, and the amplitude of a single line."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.fft import prev_fast_len

from mechid.arrays import FloatArray
from mechid.errors import UsageError, did_you_mean
from mechid.signal.envelope import peak_groups
from mechid.signal.series import Series
from mechid.signal.transform import transform_blocks

WINDOWS: Mapping[str, Callable[[int], FloatArray]] = {
    "boxcar": np.ones,
    "hann": lambda size: np.hanning(size + 1)[:-1],
    "hamming": lambda size: np.hamming(size + 1)[:-1],
    "blackman": lambda size: np.blackman(size + 1)[:-1],
}
"""Periodic windows by name: the last sample does not repeat the first one."""


def amplitude_spectrum(y: FloatArray, sample_rate: float, window: str = "boxcar") -> tuple[FloatArray, FloatArray]:
    """Return the single-sided amplitude spectrum; a sine of amplitude A on a bin has the value A.

    Parameters
    ----------
    y : ndarray, shape (N,)
        Samples in any unit.
    sample_rate : float
        In Hz.
    window : str
        One of `WINDOWS`; its mean is divided out.

    Returns
    -------
    frequency : ndarray, shape (N // 2 + 1,)
        In Hz, from 0.
    amplitude : ndarray, shape (N // 2 + 1,)
        In the unit of `y`; at 0 the magnitude of the mean.

    Raises
    ------
    UsageError
        The window is unknown.
    """
    if window not in WINDOWS:
        known = did_you_mean(window, WINDOWS) or "; known are " + ", ".join(WINDOWS)
        raise UsageError(f'unknown window "{window}"{known}')
    weights = WINDOWS[window](y.size)
    amplitude = np.abs(np.fft.rfft(y * weights)) * (2.0 / weights.sum())
    # Mean and Nyquist bin have no mirror image.
    single = [0, -1] if y.size % 2 == 0 else [0]
    amplitude[single] /= 2.0
    frequency = np.arange(amplitude.size) * (sample_rate / y.size)
    return frequency.astype(np.float64), amplitude.astype(np.float64)


def peak_spectrum(y: Series, sample_rate: float, most: int) -> tuple[FloatArray, FloatArray]:
    """Return the maxima of the single-sided amplitude spectrum in groups of bins, for records of any length.

    The last samples, rarely more than a few, are ignored: the transform of a length with a large prime factor needs
    several times the memory.

    Parameters
    ----------
    y : Series of N samples
        In any unit.
    sample_rate : float
        In Hz.
    most : int
        Maximum number of groups, of equal width on a logarithmic axis.

    Returns
    -------
    frequency : ndarray, shape (M,)
        Centre of each group in Hz, without the bin at 0.
    amplitude : ndarray, shape (M,)
        In the unit of `y`.
    """
    size = int(prev_fast_len(y.size, real=True))
    bins = size // 2 + 1
    starts = peak_groups(bins, most)
    peaks = np.zeros(starts.size)
    for numbers, values in transform_blocks(y, size):
        # The Nyquist bin has no mirror image.
        single = np.where(2 * numbers == size, 1.0, 2.0) / size
        some = numbers > 0
        group = np.searchsorted(starts, numbers[some], side="right") - 1
        # One NaN sample makes all bins NaN, which the caller sees; NumPy's warning would add nothing.
        with np.errstate(invalid="ignore"):
            np.maximum.at(peaks, group, (np.abs(values) * single)[some])
    middle = (starts + np.append(starts[1:], bins) - 1) // 2
    return middle * (sample_rate / size), peaks


def line_amplitude(y: FloatArray, sample_rate: float, frequency: float) -> float:
    """Return the amplitude of the sine at `frequency`, fitted to `y` jointly with a constant by least squares.

    At a bin of the record's spectrum it equals that bin's amplitude; for a sine between bins it is exact too.

    Parameters
    ----------
    y : ndarray, shape (N,)
        Samples in any unit.
    sample_rate, frequency : float
        In Hz; the frequency lies between 0 and half the sample rate.

    Raises
    ------
    UsageError
        The frequency is out of that range.
    """
    if not 0.0 < frequency < sample_rate / 2.0:
        raise UsageError(f"the frequency of a line, {frequency} Hz, is not between 0 and {sample_rate / 2.0} Hz")
    phase = 2.0 * np.pi * frequency / sample_rate * np.arange(y.size)
    columns = np.column_stack((np.cos(phase), np.sin(phase), np.ones(y.size)))
    cosine, sine, _ = np.linalg.solve(columns.T @ columns, columns.T @ y)
    return float(np.hypot(cosine, sine))
