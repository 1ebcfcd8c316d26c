"""Detection of spectral lines: sines above the surrounding noise, with their standard errors.

Each bin of the Hann-windowed periodogram is compared with the running median of its neighbours. For noise of any
colour the ratio is exponentially distributed with median 1: it exceeds r with probability 2^-r.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.fft import prev_fast_len
from scipy.ndimage import median_filter

from mechid.arrays import FloatArray
from mechid.signal import stored_series
from mechid.signal.series import Series
from mechid.signal.settings import SERIES
from mechid.signal.spectrum import amplitude_spectrum

NEIGHBOURS = 401
"""Number of bins of the running median."""
LEAST_RATIO = 30.0
"""Least ratio of a line; a record of noise with a million bins exceeds it with a probability of 0.001."""


@dataclass(frozen=True, kw_only=True)
class Line:
    """Sine in a series.

    Attributes
    ----------
    frequency_hz : float
    amplitude, sigma : float
        Amplitude and its standard error from the surrounding noise, in the series' unit.
    ratio : float
        Power relative to the median of the surrounding bins.
    """

    frequency_hz: float
    amplitude: float
    sigma: float
    ratio: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Prominence:
    """Hann-windowed spectrum of a series with its local noise level.

    Attributes
    ----------
    samples : int
        Number N of transformed samples.
    sample_rate_hz : float
    amplitude, level : (N // 2 + 1,)
        Amplitude of a sine, in the series' unit; median power of the surrounding bins, in that unit squared.
    """

    samples: int
    sample_rate_hz: float
    amplitude: FloatArray
    level: FloatArray

    @property
    def bin_hz(self) -> float:
        """Spacing of the bins."""
        return self.sample_rate_hz / self.samples

    @property
    def ratio(self) -> FloatArray:
        """Power relative to the local level, (N // 2 + 1,); 0 where the level is zero."""
        return np.divide(self.amplitude**2, self.level, out=np.zeros_like(self.level), where=self.level > 0.0)

    def line_at(self, number: int) -> Line:
        """Return the line that peaks in a bin, with interpolated frequency and amplitude.

        Under a Hann window a sine at a distance of d bins appears with sinc(d) / (1 - d^2) of its amplitude. The ratio
        a of the larger neighbour to the peak determines d = (2 a - 1) / (a + 1).
        """
        left, peak, right = self.amplitude[number - 1 : number + 2].tolist()
        share = max(left, right) / peak if peak > 0.0 else 0.5
        off = min(max((2.0 * share - 1.0) / (share + 1.0), 0.0), 0.5)
        return Line(
            frequency_hz=(number + (off if right > left else -off)) * self.bin_hz,
            amplitude=peak * (1.0 - off**2) / float(np.sinc(off)),
            sigma=math.sqrt(0.5 * float(self.level[number]) / math.log(2.0)),
            ratio=float(self.ratio[number]),
        )


def prominence(y: Series, sample_rate: float) -> Prominence:
    """Return the spectrum of a series with its local noise level.

    The last few samples are ignored, to obtain a length that is fast to transform. Of a long series only the first
    `stored_series.MAX_IN_MEMORY` samples are used; a bin is then a few mHz wide.

    Parameters
    ----------
    y : Series of N samples
        In any unit.
    sample_rate : float
        In Hz.
    """
    series = y[: int(prev_fast_len(min(y.size, stored_series.MAX_IN_MEMORY), real=True))]
    amplitude = amplitude_spectrum(series - series.mean(), sample_rate, "hann")[1]
    width = min(NEIGHBOURS, amplitude.size)
    level = median_filter(amplitude**2, width, mode="mirror")
    return Prominence(samples=series.size, sample_rate_hz=sample_rate, amplitude=amplitude, level=level)


def spectral_lines(found: Prominence, least_ratio: float = LEAST_RATIO, most: int = 200) -> tuple[Line, ...]:
    """Return the `most` largest peaks with at least `least_ratio`, sorted by frequency."""
    power, ratio = found.amplitude, found.ratio
    inside = np.arange(SERIES.lowest_bin, power.size - 1)
    peaks = inside[(power[inside] >= power[inside - 1]) & (power[inside] > power[inside + 1])]
    peaks = peaks[ratio[peaks] >= least_ratio]
    peaks = np.sort(peaks[np.argsort(-power[peaks], kind="stable")[:most]])
    return tuple(found.line_at(int(number)) for number in peaks)
