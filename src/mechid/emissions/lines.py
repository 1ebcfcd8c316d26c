"""Lines of one channel: sines above the noise, their amplitudes over the windows, orders and multiples of the mains."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import gammainccinv

from mechid.arrays import BoolArray, FloatArray, IntArray
from mechid.emissions.bounds import line_bounds
from mechid.emissions.settings import EMISSION
from mechid.emissions.spectra import Spectra


@dataclass(frozen=True, kw_only=True, eq=False)
class Lines:
    """Lines by frequency; each array has one entry for each, (n,).

    Attributes
    ----------
    frequency_hz : ndarray
    bins : ndarray of int
        Bin of its peak.
    amplitude : ndarray
        Peak value of the sine, Rice bias removed, root mean square over the windows.
    sigma : ndarray
        Standard error, from the noise beside the line or the scatter over the windows, the larger one.
    ratio : ndarray
        Power over that of the noise.
    response : ndarray
        Reading of the window at the bin over the amplitude.
    scatter : ndarray
        Scatter of the amplitude over the windows, over what the noise makes of it; at least 1.
    windows : int
        Independent windows.
    noise : ndarray
        Squared amplitude that noise alone reads in the bin.
    """

    frequency_hz: FloatArray
    bins: IntArray
    amplitude: FloatArray
    sigma: FloatArray
    ratio: FloatArray
    response: FloatArray
    scatter: FloatArray
    windows: int
    noise: FloatArray

    def bounds(self, alpha_lower: float, alpha_upper: float) -> tuple[FloatArray, FloatArray]:
        """Return bounds of the amplitudes, (n,) each, widened by the scatter over the windows."""
        lower = np.sqrt(line_bounds(self.ratio, self.windows, alpha_lower)[0] * self.noise) / self.response
        upper = np.sqrt(line_bounds(self.ratio, self.windows, alpha_upper)[1] * self.noise) / self.response
        below = np.maximum(self.amplitude - self.scatter * (self.amplitude - lower), 0.0)
        return below, self.amplitude + self.scatter * (upper - self.amplitude)


def find_lines(spectra: Spectra) -> Lines:
    """Return the lines that stand out of the noise of a channel."""
    power = spectra.apart * spectra.peak_scale
    windows, bins = power.shape
    mean, noise = power.mean(axis=0), spectra.noise * spectra.peak_scale
    ratio = mean / noise
    # The mean of W periodogram values of noise is a gamma variable; the chance is shared by all bins.
    least = float(gammainccinv(windows, EMISSION.by_chance / bins)) / windows
    peaks = _peaks(mean, ratio, least)
    response, off = _response(np.maximum(mean - noise, 0.0), peaks)
    amplitude = np.sqrt(np.maximum(mean[peaks] - noise[peaks], 0.0)) / response
    scatter = np.std(np.sqrt(power[:, peaks]), axis=0, ddof=1) if windows > 1 else np.zeros(peaks.size)
    # a sine's amplitude in one window scatters by half the noise's squared amplitude
    excess = np.maximum(scatter / np.sqrt(0.5 * noise[peaks]), 1.0)
    sigma = np.sqrt(0.5 * noise[peaks] / windows) / response * excess
    kept = ~_is_leakage(peaks + off, amplitude)
    return Lines(
        frequency_hz=(peaks + off)[kept] * spectra.bin_hz,
        bins=peaks[kept],
        amplitude=amplitude[kept],
        sigma=sigma[kept],
        ratio=ratio[peaks][kept],
        response=response[kept],
        scatter=excess[kept],
        windows=windows,
        noise=noise[peaks][kept],
    )


def _peaks(mean: FloatArray, ratio: FloatArray, least: float) -> IntArray:
    """Return the bins that are the largest within one on each side and above the least ratio."""
    inside = np.arange(EMISSION.first_bin, mean.size - 1)
    is_peak = (mean[inside] >= mean[inside - 1]) & (mean[inside] > mean[inside + 1]) & (ratio[inside] > least)
    return inside[is_peak]


def _response(power: FloatArray, peaks: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the window's response at each peak, and by how many bins the line is off it.

    Under Hann's window a sine d bins off reads sinc(d) / (1 - d^2) of its amplitude, and the larger neighbour's share a
    of the peak tells d = (2 a - 1) / (a + 1).
    """
    left, middle, right = (np.sqrt(power[peaks + k]) for k in (-1, 0, 1))
    # A peak that does not exceed the noise counts as on its bin: a share of one half gives an offset of 0.
    share = np.divide(np.maximum(left, right), middle, out=np.full(peaks.size, 0.5), where=middle > 0.0)
    off = np.clip((2.0 * share - 1.0) / (share + 1.0), 0.0, 0.5)
    return np.sinc(off) / (1.0 - off**2), np.where(right > left, off, -off)


def _is_leakage(position: FloatArray, amplitude: FloatArray) -> BoolArray:
    """Tell which peaks are no more than twice what the window leaks of all others there, (n,); positions in bins."""
    if position.size > 2000:  # noise that is far from smooth; none is singled out
        return np.zeros(position.size, dtype=np.bool_)
    apart = np.abs(position[:, None] - position[None, :])
    # Envelope of the side lobes of Hann's window: |sin(pi d)| is set to 1.
    leak = np.minimum(1.0 / (np.pi * np.maximum(apart, 1.5) * (np.maximum(apart, 1.5) ** 2 - 1.0)), 1.0)
    np.fill_diagonal(leak, 0.0)
    return np.asarray(amplitude < 2.0 * (leak @ amplitude), dtype=np.bool_)


def orders_of(frequency_hz: FloatArray, rate: float, bin_hz: float) -> FloatArray:
    """Return the order of the step rate that each line is, (n,); NaN where it is none or the rate is not known.

    Examples
    --------
    >>> orders_of(np.array([46.0, 50.0, 92.1]), 46.0, 0.25).tolist()
    [1.0, nan, 2.0]
    """
    step = EMISSION.order_step * abs(rate)
    # Orders that lie closer than their tolerance would claim every line.
    if not math.isfinite(step) or step < 2.0 * EMISSION.near_bins * bin_hz:
        return np.full(frequency_hz.size, np.nan)
    number = np.round(frequency_hz / step)
    order = number * EMISSION.order_step
    is_near = np.abs(frequency_hz - number * step) <= EMISSION.near_bins * bin_hz
    return np.where(is_near & (number > 0) & (order <= EMISSION.most_order), order, np.nan)


def mains_of(frequency_hz: FloatArray, spectra: Spectra) -> FloatArray:
    """Return the nominal multiple of the mains in Hz that each line is, (n,); NaN where it is none."""
    found = np.full(frequency_hz.size, np.nan)
    for line in spectra.mains:
        near = np.abs(frequency_hz - line.line.frequency_hz) <= EMISSION.near_bins * spectra.bin_hz
        found[near] = line.mains_hz * line.multiple
    return found
