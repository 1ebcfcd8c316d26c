"""Spectral distance of two series, insensitive to phases, offsets and small time shifts."""

from __future__ import annotations

import numpy as np
from scipy.fft import prev_fast_len

from mechid.arrays import FloatArray
from mechid.signal.settings import SERIES
from mechid.signal.spectrum import amplitude_spectrum
from mechid.signal.trend import fit_line


def power_over_time(y: FloatArray, pieces: int) -> FloatArray:
    """Return the smoothed power spectra, (pieces, F), of equal pieces of a series, each detrended.

    Parameters
    ----------
    y : (N,)
        In any unit. Samples beyond the last complete piece are ignored; pieces are shortened by a few samples to a
        length that is fast to transform.
    pieces : int
    """
    size = int(prev_fast_len(max(y.size // pieces, 1), real=True))
    return np.array([_power(np.array(part)) for part in y[: pieces * size].reshape(pieces, size)])


def _power(y: FloatArray) -> FloatArray:
    fit_line(y, 2).subtract_from(y)
    _, amplitude = amplitude_spectrum(y, 1.0, "hann")
    return np.convolve(0.5 * amplitude**2, np.ones(SERIES.smoothed), "same")[SERIES.lowest_bin :]


def noise_power(sigma: float, samples: int) -> float:
    """Return the expected value of `power_over_time` for white noise in pieces of a given number of samples."""
    # A Hann window's noise bandwidth is 1.5 bins, hence 2 * 1.5 sigma^2 / samples for each of the summed bins.
    return SERIES.smoothed * 3.0 * sigma**2 / samples


def spectral_distance(measured: FloatArray, modelled: FloatArray, noise: float) -> float:
    """Return the mean square of the log10 ratio of two power spectra over the bins above the noise.

    Parameters
    ----------
    measured, modelled : arrays of equal shape
        Powers, with noise and without.
    noise : float
        Power of the noise in each entry.

    Returns
    -------
    float
        In decades squared; 0 if too few bins are above the noise.

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
