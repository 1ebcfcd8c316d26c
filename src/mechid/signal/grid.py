"""Estimation of the mains frequency from the hum in several series, and of its drift within one series.

The lines of hum are at multiples of one frequency in all series, so all series contribute to its estimate. The mains
frequency drifts by a few mHz per minute: in a long series its line is broader than that of a sine, and is modelled by
a few closely spaced sines.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import fft, ifft, next_fast_len
from scipy.special import gammainccinv

from mechid.arrays import ComplexArray, FloatArray
from mechid.signal import stored_series
from mechid.signal.series import Series, blocks
from mechid.signal.settings import HUM
from mechid.signal.window import hann

LONG = 2**14
"""Samples up to which a series is transformed as a whole: shorter ones are not worth a band of their own."""
BESIDE, CLEAR = 1024, 32
"""Bins taken on either side of the frequencies; those of them next to the frequencies are not tapered."""


@dataclass(frozen=True, eq=False)
class HumSeries:
    """Series to be searched for hum.

    Attributes
    ----------
    series : Series of N samples
    sample_rate_hz : float
    is_clear : callable
        Function of a frequency and a half-width in Hz, True if no other source has a line in this band.
    """

    series: Series
    sample_rate_hz: float
    is_clear: Callable[[float, float], bool] = lambda hz, reach: True

    @property
    def duration_s(self) -> float:
        """Duration of the analysed samples."""
        return min(self.series.size, stored_series.MAX_IN_MEMORY) / self.sample_rate_hz

    def reaches(self, hz: float) -> bool:
        """Return whether the sample rate covers a frequency and the series is long enough for its surroundings."""
        return (
            hz + HUM.around_hz < min(HUM.highest_hz, 0.45 * self.sample_rate_hz)
            and self.series.size > 4 * HUM.around_bins
        )


@dataclass(frozen=True, eq=False)
class Evidence:
    """Evidence for the mains frequency in a series.

    Attributes
    ----------
    frequency_hz : (F,)
        Candidate frequencies.
    gain : (F,)
        Power relative to that of the surrounding noise, summed over the clear multiples.
    summed : int
        Number of these multiples.
    """

    frequency_hz: FloatArray
    gain: FloatArray
    summed: int

    @property
    def best_hz(self) -> float:
        """Frequency of the largest gain, refined by parabolic interpolation."""
        at = int(np.argmax(self.gain))
        if not 0 < at < self.gain.size - 1:
            return float(self.frequency_hz[at])
        left, peak, right = self.gain[at - 1 : at + 2].tolist()
        bend = left - 2.0 * peak + right
        off = 0.5 * (left - right) / bend if bend < 0.0 else 0.0
        return float(self.frequency_hz[at] + off * (self.frequency_hz[1] - self.frequency_hz[0]))

    def at(self, hz: float) -> float:
        """Return the gain at a frequency."""
        return float(np.interp(hz, self.frequency_hz, self.gain))

    @property
    def is_evident(self) -> bool:
        """Whether the largest gain is significantly above that of noise."""
        # For noise each summand is exponentially distributed, so their sum follows a gamma distribution.
        return self.summed > 0 and self.at(self.best_hz) > float(gammainccinv(self.summed, HUM.by_chance))


@dataclass(frozen=True)
class Grid:
    """Mains frequency detected in a set of series.

    Attributes
    ----------
    hz : float
        Common frequency of all series.
    own_hz : tuple of float
        Frequency in each series, equal to the common one unless the series differs significantly.
    shown : tuple of bool
        Whether the hum is detectable in each series by itself.
    """

    hz: float
    own_hz: tuple[float, ...]
    shown: tuple[bool, ...]


def evident_grid(some: Sequence[HumSeries], nominal_hz: float) -> Grid | None:
    """Return the mains frequency estimated jointly from several series, or None if no hum is detected.

    Parameters
    ----------
    some : sequence of HumSeries
    nominal_hz : float
        Nominal mains frequency, the centre of the search.
    """
    longest = max((one.duration_s for one in some), default=0.0)
    if longest == 0.0:
        return None
    count = int(2.0 * HUM.off_hz * HUM.fine * max(HUM.multiples) * longest) + 3
    frequency = nominal_hz + np.linspace(-HUM.off_hz, HUM.off_hz, count)
    each = [_evidence(one, frequency, nominal_hz) for one in some]
    joint = Evidence(frequency, np.sum([e.gain for e in each], axis=0), sum(e.summed for e in each))
    if not joint.is_evident:
        return None
    hz = joint.best_hz
    return Grid(hz, tuple(_own_frequency(e, hz) for e in each), tuple(e.at(hz) > HUM.of_its_own for e in each))


def _own_frequency(evidence: Evidence, common_hz: float) -> float:
    best = evidence.best_hz
    is_own = evidence.is_evident and evidence.at(best) > evidence.at(common_hz) + HUM.of_its_own
    return best if is_own else common_hz


def _evidence(one: HumSeries, frequency: FloatArray, nominal_hz: float) -> Evidence:
    """Return the signal-to-noise power ratio at candidate frequencies, (F,), summed over the clear multiples."""
    total = np.zeros(frequency.size)
    multiples = [k for k in HUM.multiples if one.reaches(k * nominal_hz)]
    clear = [k for k in multiples if one.is_clear(k * nominal_hz, k * HUM.off_hz + 2.0 / one.duration_s)]
    if not clear:
        return Evidence(frequency, total, 0)
    y = np.asarray(one.series[: stored_series.MAX_IN_MEMORY])
    power = _powers((y - y.mean()) * hann(y.size), one.sample_rate_hz)
    for k in clear:
        reach = min(max(HUM.around_hz, HUM.around_bins / one.duration_s), k * nominal_hz)
        surroundings = k * nominal_hz + np.arange(-reach, reach, 1.0 / one.duration_s)
        outside = np.abs(surroundings - k * nominal_hz) > k * HUM.off_hz + 2.0 / one.duration_s
        if not outside.any():
            continue
        # The median of exponentially distributed power is ln 2 times its mean, and insensitive to other lines.
        level = float(np.median(power(surroundings)[outside])) / math.log(2.0)
        if level > 0.0:
            total += power(k * frequency) / level
    return Evidence(frequency, total, len(clear))


def _powers(y: FloatArray, sample_rate_hz: float) -> Callable[[FloatArray], FloatArray]:
    """Return `_power` of a windowed series as a function of the frequencies.

    A window's lines are three bins wide, so of a long series the bins around the frequencies suffice: as a series of
    their own they are a hundred times shorter. Amplitudes differ from those of the whole by less than 1e-3 of the
    noise, even beside a sweep of a thousand times the noise.
    """
    if y.size <= LONG:
        return lambda hz: _power(y, sample_rate_hz, hz)
    bins, bin_hz = fft(y), sample_rate_hz / y.size

    def power(hz: FloatArray) -> FloatArray:
        first, last = int(hz[0] / bin_hz) - BESIDE, int(hz[-1] / bin_hz) + 1 + BESIDE
        count = last - first + 1
        k = np.arange(count)
        # A smooth end of the band, or lines cut off there would reach far into it.
        taper = np.sin(0.5 * np.pi * np.clip(np.minimum(k, count - 1 - k) / (BESIDE - CLEAR), 0.0, 1.0)) ** 2
        # Sums over N and over `count` samples turn by another phase from bin to bin.
        turn = np.exp(1j * np.pi * k * (1.0 / count - 1.0 / y.size))
        return _power(ifft(bins[(first + k) % y.size] * taper * turn), count * bin_hz, hz - first * bin_hz)

    return power


def _power(y: FloatArray | ComplexArray, sample_rate_hz: float, hz: FloatArray) -> FloatArray:
    """Return |sum of y exp(-2 pi i hz t)|^2 at evenly spaced frequencies, (m,), by Bluestein's chirp transform."""
    # scipy.signal.zoom_fft does the same, but its import would add 0.4 s to every identification.
    n, m = y.size, hz.size
    first, step = hz[0] / sample_rate_hz, (hz[-1] - hz[0]) / max(m - 1, 1) / sample_rate_hz
    k = np.arange(max(n, m))
    # Phases are reduced to one turn before the exponential: k^2 is large enough to cost digits otherwise.
    chirp = np.exp(1j * np.pi * ((step * k * k) % 2.0))
    turned = y * np.exp(-2j * np.pi * ((first * k[:n]) % 1.0)) / chirp[:n]
    size = next_fast_len(n + m - 1)
    answer = np.zeros(size, dtype=np.complex128)
    answer[:m] = chirp[:m]
    answer[size - n + 1 :] = chirp[1:n][::-1]
    found = ifft(fft(turned, size) * fft(answer))[:m]
    return np.asarray(np.abs(found) ** 2, dtype=np.float64)


def drifting_lines(one: HumSeries, hz: float) -> tuple[float, ...]:
    """Return the frequencies in Hz of closely spaced lines that model a line of slowly drifting phase and amplitude.

    The Bayesian information criterion selects their number.
    """
    n = one.series.size
    duration_s = n / one.sample_rate_hz
    if duration_s < HUM.shortest_s:
        return (hz,)
    slow = _envelope(one, hz)
    t = np.arange(1, slow.size + 1) / HUM.envelope_hz
    best, least = 0, np.inf
    for beside in range(HUM.most_beside + 1):
        columns = np.exp(2j * np.pi * np.outer(t, _satellite_offsets(beside, duration_s)))
        # Lines half an inverse duration apart are nearly collinear: small singular values are cut off.
        left = slow - columns @ np.linalg.lstsq(columns, slow, rcond=1e-6)[0]
        power = max(float(np.mean(np.abs(left) ** 2)), 1e-300)
        score = slow.size * np.log(power) + (2 * beside + 1) * np.log(2.0 * slow.size)
        if score < least:
            best, least = beside, score
    return tuple((hz + _satellite_offsets(best, duration_s)).tolist())


def combined_amplitude(lines: Sequence[tuple[float, float, float]]) -> float:
    """Return the amplitude of the sine that has the power of several closely spaced lines, in their unit.

    Parameters
    ----------
    lines : sequence of (float, float, float)
        Frequency in Hz, amplitude, and phase at the first sample in rad, with the spacing of `drifting_lines`.
    """
    hz, size, phase = np.array(lines).T
    if hz.size == 1:
        return float(size[0])
    duration_s = HUM.apart / float(np.min(np.diff(np.sort(hz))))
    t = np.linspace(0.0, duration_s, 64 * hz.size)
    envelope = np.exp(2j * np.pi * np.outer(t, hz - hz.mean())) @ (size * np.exp(1j * phase))
    return float(np.sqrt(np.mean(np.abs(envelope) ** 2)))


def _satellite_offsets(count: int, duration_s: float) -> FloatArray:
    return np.asarray(np.arange(-count, count + 1) * HUM.apart / duration_s, dtype=np.float64)


def _envelope(one: HumSeries, hz: float) -> ComplexArray:
    """Return the slow complex envelope of a line, averaged by Hann windows of half a second with half overlap.

    The windows prevent distant lines, such as other multiples, from leaking into the envelope.
    """
    each = max(int(one.sample_rate_hz / HUM.envelope_hz), 1)
    windows, weights = max(one.series.size // each - 1, 1), hann(2 * each) / each
    found = np.zeros(windows + 2, dtype=np.complex128)
    for part in blocks(min((windows + 1) * each, one.series.size)):
        k = np.arange(part.start, part.stop)
        turned = np.asarray(one.series[part]) * np.exp(-2j * np.pi * ((hz / one.sample_rate_hz * k) % 1.0))
        # With half overlap each sample belongs to two windows.
        for window in (k // each, k // each + 1):
            np.add.at(found, window, weights[k - (window - 1) * each] * turned)
    return np.asarray(found[1 : windows + 1])
