"""Spectra of one channel: densities of windows, their mean, and the level of the noise beneath the lines.

One-sided power density under a periodic Hann window, half overlap, each window's mean removed: as
``scipy.signal.welch(y, fs, "hann", L, L // 2, detrend="constant")``. The equivalent noise bandwidth is 1.5 bins, so
that a sine of amplitude A on a bin reads A^2 / (3 bin width).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.fft import prev_fast_len
from scipy.special import gammaincinv

from mechid.arrays import BoolArray, FloatArray
from mechid.emissions.settings import EMISSION
from mechid.signal.lines import Prominence
from mechid.signal.mains import MainsLine, mains_lines
from mechid.signal.window import windowed_density
from mechid.specification.settings import SPECIFICATION

NOISE_BANDWIDTH = 1.5
"""Of Hann's window, in bins."""
AT_ONCE = 8
"""Windows that are transformed together."""
OVERLAP_CORRELATION = 1.0 / 36.0
"""Of the powers of half overlapping Hann windows: the square of 1/6."""
BIN_CORRELATION = 1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0)
"""Variance of a sum of neighbouring bins over that of independent ones: the squares of 2/3 and 1/6."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Spectra:
    """Power densities of the windows of one channel.

    Attributes
    ----------
    rows : ndarray, shape (K, M)
        Density of each half overlapping window, unit squared per Hz.
    bin_hz : float
    sample_rate_hz : float
    bench_hz : (float, float)
        Band that the bench supports in this direction.
    """

    rows: FloatArray
    bin_hz: float
    sample_rate_hz: float
    bench_hz: tuple[float, float] = (0.0, np.inf)

    @cached_property
    def density(self) -> FloatArray:
        """Mean over the windows, (M,)."""
        return np.asarray(self.rows.mean(axis=0), dtype=np.float64)

    @cached_property
    def noise(self) -> FloatArray:
        """Level of the noise beneath the lines, (M,)."""
        return noise_level(self.density, self.dof)

    @property
    def frequency_hz(self) -> FloatArray:
        """Of each bin, (M,)."""
        return np.asarray(np.arange(self.rows.shape[1]) * self.bin_hz, dtype=np.float64)

    @property
    def dof(self) -> float:
        """Degrees of freedom of the mean density of noise."""
        count = len(self.rows)
        # With half overlap, a window shares samples with its two neighbours alone.
        return 2.0 * count / (1.0 + 2.0 * OVERLAP_CORRELATION * (count - 1) / count)

    @property
    def apart(self) -> FloatArray:
        """Densities of the windows that do not overlap, (W, M)."""
        return self.rows[::2]

    @property
    def peak_scale(self) -> float:
        """Squared amplitude of a sine over the density of its bin."""
        return 2.0 * NOISE_BANDWIDTH * self.bin_hz

    @property
    def variance(self) -> FloatArray:
        """Variance of the mean density, (M,): that of the noise, and the noise's product with what stands above it."""
        above = np.maximum(self.density - self.noise, 0.0)
        return np.asarray((self.noise**2 + 2.0 * above * self.noise) * (2.0 / self.dof), dtype=np.float64)

    @cached_property
    def mains(self) -> tuple[MainsLine, ...]:
        """Lines of the electric grid."""
        # `Prominence` takes a median power, which is log(2) times the mean of an exponential distribution.
        level = self.noise * (self.peak_scale * np.log(2.0))
        found = Prominence(
            samples=round(self.sample_rate_hz / self.bin_hz),
            sample_rate_hz=self.sample_rate_hz,
            amplitude=np.sqrt(self.density * self.peak_scale),
            level=level,
        )
        return mains_lines(found)

    @property
    def usable_hz(self) -> tuple[float, float]:
        """Lowest and highest frequency that can be judged."""
        low, high = usable_band(self.bin_hz, self.sample_rate_hz)
        return max(low, self.bench_hz[0]), min(high, self.bench_hz[1])

    def usable_bins(self) -> BoolArray:
        """Tell which bins can be judged, (M,)."""
        low, high = self.usable_hz
        return (self.frequency_hz >= low) & (self.frequency_hz <= high)


def usable_band(bin_hz: float, sample_rate_hz: float) -> tuple[float, float]:
    """Return the lowest and the highest frequency in Hz that a record can be judged at."""
    return EMISSION.first_bin * bin_hz, sample_rate_hz / SPECIFICATION.guard


def window_length(samples: int, sample_rate_hz: float) -> int:
    """Return the samples of a window, even and quick to transform.

    Examples
    --------
    >>> window_length(600_000, 10_000.0), window_length(20_000, 10_000.0)
    (40000, 2500)
    """
    longest = min(samples // EMISSION.least_windows, round(SPECIFICATION.window_s * sample_rate_hz))
    # Half of the length is rounded down to a fast one, so that the whole is even.
    return 2 * int(prev_fast_len(max(longest // 2, 8), real=True))


def channel_spectra(
    y: FloatArray, sample_rate_hz: float, length: int, bench_hz: tuple[float, float] = (0.0, np.inf)
) -> Spectra:
    """Return the densities of all half overlapping windows of a channel.

    Parameters
    ----------
    y : ndarray, shape (N,)
        N at least `length`.
    sample_rate_hz : float
    length : int
        Samples of a window, even.
    bench_hz : (float, float)
        Band that the bench supports.
    """
    windows = np.lib.stride_tricks.sliding_window_view(y, length)[:: length // 2]
    # Windowed copies of all windows together would take twice the memory of the record.
    parts = [windowed_density(windows[k : k + AT_ONCE], sample_rate_hz) for k in range(0, len(windows), AT_ONCE)]
    return Spectra(
        rows=np.concatenate(parts),
        bin_hz=sample_rate_hz / length,
        sample_rate_hz=sample_rate_hz,
        bench_hz=bench_hz,
    )


def noise_level(density: FloatArray, dof: float) -> FloatArray:
    """Return the level of the noise from low quantiles of blocks of bins, (M,).

    Blocks grow with the frequency. A low quantile is not raised by lines, which fill a part of the bins; the same
    quantile of a chi-square value makes a mean of it.
    """
    first, bins = EMISSION.first_bin, density.size
    edges = [first]
    while edges[-1] < bins:
        edges.append(edges[-1] + max(EMISSION.least_block, int(EMISSION.block_share * edges[-1])))
    if len(edges) > 2:
        edges.pop()  # what is left at the end joins the last block
    edges[-1] = bins
    share = float(gammaincinv(0.5 * dof, EMISSION.quantile)) / (0.5 * dof)
    pairs = list(pairwise(edges))
    level = np.array([np.quantile(density[a:b], EMISSION.quantile) for a, b in pairs]) / share
    middle = np.array([np.sqrt(a * (b - 1.0)) for a, b in pairs])
    tiny = np.finfo(np.float64).tiny
    # On logarithmic axes coloured noise is nearly straight.
    number = np.log(np.maximum(np.arange(bins), 1))
    return np.asarray(np.exp(np.interp(number, np.log(middle), np.log(np.maximum(level, tiny)))), dtype=np.float64)
