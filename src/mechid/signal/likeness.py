"""Spectral distance of two series: phases, offsets and small shifts of time do not count."""

from __future__ import annotations

import numpy as np
from scipy.fft import prev_fast_len

from mechid.arrays import FloatArray
from mechid.signal.settings import SERIES
from mechid.signal.spectrum import amplitude_spectrum
from mechid.signal.trend import fit_line


def power_over_time(y: FloatArray, pieces: int) -> FloatArray:
    """Return the power around each frequency, (pieces, F), of equal pieces of a series, each without offset and drift.

    Parameters
    ----------
    y : (N,)
        In any unit; what does not fill the last piece is left out, and so are a few
        samples for the transform's sake.
    pieces : int
    """
    size = int(prev_fast_len(max(y.size // pieces, 1), real=True))
    return np.array([_power(np.array(part)) for part in y[: pieces * size].reshape(pieces, size)])


def _power(y: FloatArray) -> FloatArray:
    fit_line(y, 2).take_from(y)
    _, amplitude = amplitude_spectrum(y, 1.0, "hann")
    return np.convolve(0.5 * amplitude**2, np.ones(SERIES.smoothed), "same")[SERIES.lowest_bin :]


def noise_power(sigma: float, samples: int) -> float:
    """Return what white noise gives in each entry of `power_over_time` in the mean, for pieces of so many samples."""
    return SERIES.smoothed * 3.0 * sigma**2 / samples


def spectral_distance(measured: FloatArray, modelled: FloatArray, noise: float) -> float:
    """Return the mean square of the decades between two powers where either stands above the noise; 0 without such.

    Parameters
    ----------
    measured, modelled : arrays of equal shape
        Powers; the first with noise, the second without.
    noise : float
        Power of the noise in each entry.

    Examples
    --------
    >>> power = np.logspace(0, 2, 10)
    >>> round(spectral_distance(power, 100.0 * power, 1e-9), 6)
    4.0
    """
    either = np.maximum(measured, modelled) > SERIES.above_noise * noise
    if np.count_nonzero(either) < SERIES.fewest_bins:
        return 0.0
    return float(np.mean(np.log10((measured[either] + noise) / (modelled[either] + noise)) ** 2))
