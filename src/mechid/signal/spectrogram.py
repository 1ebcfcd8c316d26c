"""Amplitude over time and frequency."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import ShortTimeFFT
from scipy.signal.windows import hann

FloatArray = NDArray[np.float64]


def spectrogram(
    y: FloatArray, sample_rate: float, window_s: float, columns: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the single-sided amplitude in windows along a record: a sine of amplitude A on a bin reads A.

    Parameters
    ----------
    y : ndarray, shape (N,)
        Samples in any unit.
    sample_rate : float
        In Hz.
    window_s : float
        Length of the Hann window, s; at most the record's.
    columns : int
        About so many windows, their centres equally far apart.

    Returns
    -------
    time : ndarray, shape (C,)
        Centres of the windows, s from the first sample.
    frequency : ndarray, shape (F,)
        Hz, from 0.
    amplitude : ndarray, shape (F, C)
        In the unit of `y`. Beyond the record's ends it is taken as zero.
    """
    length = min(max(int(window_s * sample_rate), 2), y.size)
    hop = max(y.size // max(columns, 1), 1)
    transform = ShortTimeFFT(hann(length, sym=False), hop, sample_rate, fft_mode="onesided2X", scale_to="magnitude")
    amplitude = np.abs(transform.stft(y, p0=0, p1=-(-y.size // hop)))
    times = hop / sample_rate * np.arange(amplitude.shape[1])
    return times, np.asarray(transform.f, dtype=np.float64), np.asarray(amplitude, dtype=np.float64)
