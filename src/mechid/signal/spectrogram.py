"""Amplitude over time and frequency."""

from __future__ import annotations

import numpy as np

from mechid.arrays import FloatArray
from mechid.signal.series import Series
from mechid.signal.window import hann

WINDOW_S, WINDOWS, FEWEST_WINDOWS = 0.5, 240, 8
"""Default length and number of windows; a short record has at least `FEWEST_WINDOWS` shorter ones."""


def usual_window_s(duration_s: float) -> float:
    """Return the default length of a record's windows in s."""
    return min(WINDOW_S, duration_s / FEWEST_WINDOWS)


def spectrogram(
    y: Series, sample_rate: float, window_s: float, columns: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the single-sided amplitude in windows along a record; a sine of amplitude A on a bin has the value A.

    Parameters
    ----------
    y : Series of N samples
        In any unit.
    sample_rate : float
        In Hz.
    window_s : float
        Length of the Hann window in s, limited to that of the record.
    columns : int
        Approximate number of windows; their centres are equidistant.

    Returns
    -------
    time : ndarray, shape (C,)
        Centres of the windows, s from the first sample.
    frequency : ndarray, shape (F,)
        Hz, from 0.
    amplitude : ndarray, shape (F, C)
        In the unit of `y`. The record is extended by zeros at its ends.
    """
    length = min(max(int(window_s * sample_rate), 2), y.size)
    hop = max(y.size // max(columns, 1), 1)
    window = hann(length)
    centres = np.arange(0, y.size, hop)
    amplitude = np.empty((length // 2 + 1, centres.size))
    for column, first in enumerate((centres - length // 2).tolist()):
        inside, samples = slice(max(first, 0), min(first + length, y.size)), np.zeros(length)
        samples[inside.start - first : inside.stop - first] = y[inside]
        amplitude[:, column] = np.abs(np.fft.rfft(samples * window))
    # Mean and Nyquist bin have no mirror image.
    amplitude[1 : (length + 1) // 2] *= 2.0
    amplitude /= window.sum()
    frequency = np.arange(amplitude.shape[0]) * (sample_rate / length)
    return centres / sample_rate, frequency.astype(np.float64), amplitude


def largest_rows(amplitude: FloatArray, each: int) -> FloatArray:
    """Return the maximum of each group of `each` bins, (F, C) to (ceil(F / each), C), so that no line is lost."""
    return np.asarray(np.maximum.reduceat(amplitude, np.arange(0, len(amplitude), each)), dtype=np.float64)
