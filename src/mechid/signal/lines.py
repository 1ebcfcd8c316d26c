"""Lines of a spectrum: sines that stand above what surrounds them, each with its error.

A bin of the periodogram under a Hann window is set against the running median of its neighbours. Of noise alone,
whatever its colour, the ratio is exponentially distributed with median 1: it exceeds r with probability 2^-r.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.fft import prev_fast_len
from scipy.ndimage import median_filter

from mechid.arrays import FloatArray
from mechid.signal import stored
from mechid.signal.series import Series
from mechid.signal.settings import SERIES
from mechid.signal.spectrum import amplitude_spectrum

NEIGHBOURS = 401
"""Bins whose median is the level that a line stands above."""
LEAST_RATIO = 30.0
"""From which a peak is a line: of a million bins of noise one in a thousand records has one."""


@dataclass(frozen=True, kw_only=True)
class Line:
    """A sine in a series.

    Attributes
    ----------
    frequency_hz : float
    amplitude, sigma : float
        And its standard error from the noise around it, in the series' unit.
    ratio : float
        Power over the median of the bins around it.
    """

    frequency_hz: float
    amplitude: float
    sigma: float
    ratio: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Prominence:
    """The spectrum of a series under a Hann window, beside the level of its surroundings.

    Attributes
    ----------
    samples : int
        N, of which the spectrum was taken.
    sample_rate_hz : float
    amplitude, level : (N // 2 + 1,)
        A sine's in the series' unit; the median power of the bins around, that unit squared.
    """

    samples: int
    sample_rate_hz: float
    amplitude: FloatArray
    level: FloatArray

    @property
    def bin_hz(self) -> float:
        """Distance of two bins."""
        return self.sample_rate_hz / self.samples

    @property
    def ratio(self) -> FloatArray:
        """Power over the level around, (N // 2 + 1,); 0 where there is none."""
        return np.divide(self.amplitude**2, self.level, out=np.zeros_like(self.level), where=self.level > 0.0)

    def line_at(self, number: int) -> Line:
        """Return the line whose peak is in a bin, between which its frequency and height are interpolated.

        Under a Hann window a sine d bins off reads sinc(d) / (1 - d^2) of its amplitude, and the larger neighbour's
        share a of the peak tells d = (2 a - 1) / (a + 1).
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
    """Return the spectrum of a series beside its surroundings; the last few samples are left out.

    Of a long series it is that of its beginning, `stored.IN_MEMORY` samples: a bin is then some mHz wide.

    Parameters
    ----------
    y : Series of N samples
        In any unit.
    sample_rate : float
        In Hz.
    """
    series = y[: int(prev_fast_len(min(y.size, stored.IN_MEMORY), real=True))]
    amplitude = amplitude_spectrum(series - series.mean(), sample_rate, "hann")[1]
    width = min(NEIGHBOURS, amplitude.size)
    level = median_filter(amplitude**2, width, mode="mirror")
    return Prominence(samples=series.size, sample_rate_hz=sample_rate, amplitude=amplitude, level=level)


def spectral_lines(found: Prominence, least_ratio: float = LEAST_RATIO, most: int = 200) -> tuple[Line, ...]:
    """Return the lines of a series by frequency: peaks above `least_ratio`, the `most` largest of them."""
    power, ratio = found.amplitude, found.ratio
    inside = np.arange(SERIES.lowest_bin, power.size - 1)
    peaks = inside[(power[inside] >= power[inside - 1]) & (power[inside] > power[inside + 1])]
    peaks = peaks[ratio[peaks] >= least_ratio]
    peaks = np.sort(peaks[np.argsort(-power[peaks], kind="stable")[:most]])
    return tuple(found.line_at(int(number)) for number in peaks)
