"""Estimation of the white noise floor of a record from the frequencies and times at which the signal is weakest.

The spectrum of a stepped mechanism consists of lines and transients. In contrast to white noise, they decrease with
frequency. They also leave gaps: between the lines if steps are regular, and between the transients if steps are rare.
The floor is therefore the median over time and frequency in the upper part of the band, which a minority of lines and
transients does not affect. Spectra of several lengths are used: long ones resolve lines, short ones transients.

Impacts, such as those of a gear with backlash, affect every spectrum that contains one. Between two impacts there are
windows of a few samples without one; the quietest quarter of these windows gives the floor.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mechid.arrays import BoolArray, FloatArray, IntArray
from mechid.errors import RecordError
from mechid.signal import stored_series
from mechid.signal.series import Series
from mechid.signal.settings import FLOOR

FLOOR_ERROR = 1.7
"""Relative standard error of a noise floor times the square root of the number of samples, for white Gaussian noise."""
QUARTER_POWER, TENTH_POWER = 0.454, 0.259
"""First quartile and first decile of the power in windows of differenced white noise, relative to its mean."""
QUARTER_ERROR = 3.5
"""Relative standard error of the first quartile times the square root of the number of samples."""


@dataclass(frozen=True)
class Floor:
    """Estimate of the noise power, in the samples' unit squared, with its relative standard error."""

    power: float
    error: float

    @property
    def upper_bound(self) -> float:
        """Upper confidence limit of the power."""
        return self.power * math.exp(FLOOR.significant * self.error)


def noise_floor(
    y: Series, sample_rate: float, *, above: float | None = None, rejected: IntArray | None = None
) -> float:
    """Return the standard deviation of the white noise in `y`.

    If the noise is coloured, or an anti-alias filter removes its upper end, the result is the level of the quietest
    part of the band, hence a lower bound.

    Parameters
    ----------
    y : Series of N samples
        Signal with noise, in any unit; N is at least 16. For a long series, evenly distributed segments with
        `stored_series.MAX_IN_MEMORY` samples in total are used; they give the floor to a thousandth.
    sample_rate : float
        In Hz.
    above : float or None
        Lower end of the band in Hz; by default 0.6 of the Nyquist frequency.
    rejected : ndarray of int, shape (M,), or None
        Indices of invalid samples. Segments that contain any of them are excluded, unless all segments do.

    Returns
    -------
    float
        Standard deviation of one sample, in the unit of `y`. For white Gaussian noise its relative standard error is
        about `FLOOR_ERROR` / sqrt(N).

    Raises
    ------
    RecordError
        There are fewer than 16 samples, or the band above `above` is too narrow.
    """
    lowest = FLOOR.lowest if above is None else 2.0 * above / sample_rate
    if y.size < FLOOR.minimum_samples or lowest > FLOOR.highest - 0.25:
        raise RecordError(
            f"cannot estimate a noise floor from {y.size} samples above {lowest:.2f} of the Nyquist frequency"
        )
    floors = [*_floors(y, lowest, rejected), *(_floors_between_impacts(y, rejected) if above is None else ())]
    # The minimum of many estimates is biased low: the first one stands unless another is lower significantly.
    lower = [floor for floor in floors[1:] if floor.upper_bound < floors[0].power]
    return math.sqrt(min(lower or floors[:1], key=lambda floor: floor.upper_bound).power)


def _floors(y: Series, lowest: float, rejected: IntArray | None) -> Iterator[Floor]:
    """Yield the floors of all segment lengths and sub-bands, the reference estimate first."""
    lengths = [length for length in FLOOR.segments if 4 * length <= y.size] or [min(y.size, FLOOR.segments[1])]
    for length in _usable_lengths(lengths, y.size, rejected):
        share = np.arange(length // 2 + 1) * 2.0 / length
        band = (share >= lowest) & (share < FLOOR.highest)
        hop = max(length // 2, 1)
        segments = (y.size - length) // hop + 1
        kept = _select_evenly(_complete_segments(segments, length, rejected), hop)
        power = _segment_power(y, kept * hop, length, band)
        counted = y.size * len(kept) / segments
        for parts in FLOOR.parts:
            width = (FLOOR.highest - lowest) / parts
            for columns in np.array_split(power, parts, axis=1):
                if parts == 1 or columns.shape[1] >= 4:
                    yield _floor(columns, 0.5 * counted * width)


def _floors_between_impacts(y: Series, rejected: IntArray | None) -> Iterator[Floor]:
    """Yield the floor of the quietest short windows, if their powers are distributed like those of white noise.

    They are not if the signal is sometimes constant within its resolution, or if the noise is intermittent.
    """
    power = np.concatenate([_window_power(y, first, rejected) for first in _piece_starts(y.size)])
    if power.size < FLOOR.enough:
        return
    tenth, quarter = np.quantile(power, (0.1, 0.25)) / (TENTH_POWER, QUARTER_POWER)
    error = QUARTER_ERROR / math.sqrt(FLOOR.quiet * power.size)
    # A decile of zero means that the signal is constant for over a tenth of the time: those windows hold no noise.
    if tenth > 0.0 and abs(tenth - quarter) <= (FLOOR.alike + FLOOR.significant * error) * quarter:
        yield Floor(float(quarter), error)


def _piece_starts(samples: int) -> list[int]:
    """Return the first samples of the pieces of a series; of a long one, an even selection that fits in memory."""
    starts = np.arange(0, samples - FLOOR.differences, FLOOR.piece)
    return [int(first) for first in _select_evenly(starts, FLOOR.piece)]


def _window_power(y: Series, first: int, rejected: IntArray | None) -> FloatArray:
    """Return the mean square of the differences in each window of a piece without rejected samples.

    The result is scaled so that white noise keeps its power.
    """
    # Differences of this order act as a high-pass: the slow signal vanishes while white noise remains.
    differences = np.diff(y[first : first + FLOOR.piece + FLOOR.differences], FLOOR.differences)
    windows = differences.size // FLOOR.quiet
    power = np.mean(differences[: windows * FLOOR.quiet].reshape(windows, FLOOR.quiet) ** 2, axis=1)
    power /= math.comb(2 * FLOOR.differences, FLOOR.differences)
    if rejected is not None and rejected.size:
        starts = first + FLOOR.quiet * np.arange(windows)
        power = power[
            np.searchsorted(rejected, starts) == np.searchsorted(rejected, starts + FLOOR.quiet + FLOOR.differences)
        ]
    return np.asarray(power, dtype=np.float64)


def _usable_lengths(lengths: list[int], samples: int, rejected: IntArray | None) -> list[int]:
    """Return the segment lengths with enough complete segments, including shorter ones for frequent gaps."""
    if rejected is None or not rejected.size:
        return lengths
    counted = np.diff(np.concatenate([[-1], rejected, [samples]])) - 1
    return [n for n in (*lengths, *FLOOR.between_gaps) if np.sum(counted[counted >= n] // n) >= FLOOR.enough] or lengths


def _select_evenly(kept: IntArray, hop: int) -> IntArray:
    """Return the segments, reduced to an even selection if they have more samples than a series in memory."""
    most = max(stored_series.MAX_IN_MEMORY // hop, 1)
    return kept[np.linspace(0, kept.size - 1, most).astype(np.int64)] if kept.size > most else kept


def _complete_segments(segments: int, length: int, rejected: IntArray | None) -> IntArray:
    """Return the indices of segments without rejected samples, or of all segments if there are none."""
    numbers = np.arange(segments)
    if rejected is None or not rejected.size:
        return numbers
    starts = numbers * max(length // 2, 1)
    whole = np.searchsorted(rejected, starts) == np.searchsorted(rejected, starts + length)
    return numbers[whole] if whole.any() else numbers


def _segment_power(y: Series, starts: IntArray, length: int, band: BoolArray) -> FloatArray:
    """Return the power of Hann-windowed segments in the bins of a `band`, shape (segments, bins).

    White noise with standard deviation s has an expected power of s^2 in every bin.
    """
    window = np.hanning(length + 1)[:-1]
    window /= math.sqrt(float(np.sum(window**2)))
    power = np.empty((len(starts), np.count_nonzero(band)))
    for start in range(0, len(starts), FLOOR.block):
        part = slice(start, start + FLOOR.block)
        segments = np.stack([y[first : first + length] for first in starts[part].tolist()])
        power[part] = _block_power(segments, window, band)
    return power


def _block_power(segments: FloatArray, window: FloatArray, band: BoolArray) -> FloatArray:
    centred = segments - segments.mean(axis=1, keepdims=True)
    spectrum = np.fft.rfft(centred * window, axis=1)[:, band]
    return np.asarray(spectrum.real**2 + spectrum.imag**2, dtype=np.float64)


def _floor(power: FloatArray, independent: float) -> Floor:
    """Return the floor of bins whose power follows a chi-square distribution with two degrees of freedom.

    The median of this distribution is ln 2 times its mean, and the median of n independent values has a relative
    standard error of 1 / (ln 2 sqrt(n)). A band that covers a share w of the Nyquist frequency in N samples has
    N w / 2 independent values, regardless of overlap and window.
    """
    return Floor(float(np.median(power)) / math.log(2.0), 1.0 / (math.log(2.0) * math.sqrt(independent)))
