"""Largest instantaneous value within a band over time.

The band-pass is a digital Butterworth filter of order 4 (8 poles), bilinear transform with pre-warped edges, run once
forward from rest over the samples less their mean:
``sosfilt(butter(4, [low, high], "bandpass", fs=fs, output="sos"), y - y.mean())``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mechid.arrays import FloatArray
from mechid.specification.settings import SPECIFICATION


def band_signal(y: FloatArray, sample_rate_hz: float, band_hz: tuple[float, float]) -> FloatArray:
    """Return the samples of a signal within a band, (N,)."""
    from scipy.signal import butter, sosfilt  # half a second to import, needed by this kind alone

    sections = butter(SPECIFICATION.filter_order, band_hz, "bandpass", fs=sample_rate_hz, output="sos")
    return np.asarray(sosfilt(sections, y - y.mean()), dtype=np.float64)


def band_peaks(
    y: FloatArray, sample_rate_hz: float, bands_hz: Sequence[tuple[float, float]]
) -> tuple[FloatArray, FloatArray]:
    """Return the largest magnitude and the RMS of a signal in each band, (n,) each, in its unit.

    Parameters
    ----------
    y : ndarray, shape (N,)
    sample_rate_hz : float
    bands_hz : sequence of (float, float)
        Lower and upper edge, where the power is half.
    """
    found = [band_signal(y, sample_rate_hz, band) for band in bands_hz]
    peaks = np.array([np.abs(x).max() for x in found], dtype=np.float64)
    return peaks, np.array([np.sqrt(np.mean(x**2)) for x in found], dtype=np.float64)
