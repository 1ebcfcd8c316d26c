"""The white noise in a record, told from its signal where the signal is weakest.

A stepped mechanism fills its spectrum with lines and transients, but they fall off with frequency
while white noise does not; and they leave gaps: between their lines, where step follows step
regularly, and between the transients, where steps are rare. So the floor is read in the upper part
of the band as a median over time and frequency, which lines and transients in the minority do not
move, in spectra of several lengths: long ones resolve lines, short ones transients. Impacts, as of a
gear with backlash, fill every spectrum that holds one; between two of them there are windows of some
samples that hold none, and the quarter of these that is quietest has the floor.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mechid.arrays import BoolArray, FloatArray, IntArray
from mechid.errors import RecordError
from mechid.signal import stored
from mechid.signal.series import Series
from mechid.signal.settings import FLOOR

FLOOR_ERROR = 1.7
"""Relative standard error of a floor times the root of the number of samples, white Gaussian noise."""
QUARTER, TENTH = 0.454, 0.259
"""Of the mean power of such differences of white noise: what a quarter, and a tenth, of the windows have at most."""
QUARTER_ERROR = 3.5
"""Relative standard error of that quarter times the root of the number of samples."""


@dataclass(frozen=True)
class Floor:
    """One estimate of the noise power, in the samples' unit squared, and its relative standard error."""

    power: float
    error: float

    @property
    def ceiling(self) -> float:
        """The power that it significantly stays below."""
        return self.power * math.exp(FLOOR.significant * self.error)


def noise_floor(
    y: Series, sample_rate: float, *, above: float | None = None, rejected: IntArray | None = None
) -> float:
    """Return the standard deviation of the white noise in `y`.

    Where noise is coloured, or an anti-alias filter takes its upper end away, this is the level of
    the quietest part of the band, hence a lower bound.

    Parameters
    ----------
    y : Series of N samples
        Noise and signal in any unit, N at least 16. Of a long series segments are looked at that lie evenly over it,
        as many as `stored.IN_MEMORY` samples have: they tell the floor to a thousandth.
    sample_rate : float
        In Hz.
    above : float or None
        Frequency in Hz from which the spectrum is looked at; by default 0.6 of the Nyquist frequency.
    rejected : ndarray of int, shape (M,), or None
        Samples that are no measurement: spectra that hold any of them are left out, unless all do.

    Returns
    -------
    float
        Sigma of one sample, in the unit of `y`. For white Gaussian noise its own relative standard
        error is about `FLOOR_ERROR` / sqrt(N).

    Raises
    ------
    RecordError
        Fewer than 16 samples, or no band is left above `above`.
    """
    lowest = FLOOR.lowest if above is None else 2.0 * above / sample_rate
    if y.size < FLOOR.minimum_samples or lowest > FLOOR.highest - 0.25:
        raise RecordError(f"no noise floor from {y.size} samples above {lowest:.2f} of the Nyquist frequency")
    floors = [*_floors(y, lowest, rejected), *(_between_impacts(y, rejected) if above is None else ())]
    lower = [floor for floor in floors[1:] if floor.ceiling < floors[0].power]
    return math.sqrt(min(lower or floors[:1], key=lambda floor: floor.ceiling).power)


def _floors(y: Series, lowest: float, rejected: IntArray | None) -> Iterator[Floor]:
    """Yield the floors of all segment lengths and parts of the band, the one to start from first."""
    lengths = [length for length in FLOOR.segments if 4 * length <= y.size] or [min(y.size, FLOOR.segments[1])]
    for length in _with_enough_whole(lengths, y.size, rejected):
        share = np.arange(length // 2 + 1) * 2.0 / length
        band = (share >= lowest) & (share < FLOOR.highest)
        hop = max(length // 2, 1)
        segments = (y.size - length) // hop + 1
        kept = _thinned(_whole(segments, length, rejected), hop)
        power = _power(y, kept * hop, length, band)
        worth = y.size * len(kept) / segments
        for parts in FLOOR.parts:
            width = (FLOOR.highest - lowest) / parts
            for columns in np.array_split(power, parts, axis=1):
                if parts == 1 or columns.shape[1] >= 4:
                    yield _floor(columns, 0.5 * worth * width)


def _between_impacts(y: Series, rejected: IntArray | None) -> Iterator[Floor]:
    """Yield the floor of the quietest windows of some samples, where these scatter as white noise does.

    They do not where a signal stands still within its resolution now and then, or where noise comes and goes. Where it
    stands still for more than a tenth of the time the quietest windows hold no noise at all.
    """
    power = np.concatenate([_window_power(y, first, rejected) for first in _piece_starts(y.size)])
    if power.size < FLOOR.enough:
        return
    tenth, quarter = np.quantile(power, (0.1, 0.25)) / (TENTH, QUARTER)
    error = QUARTER_ERROR / math.sqrt(FLOOR.quiet * power.size)
    if tenth > 0.0 and abs(tenth - quarter) <= (FLOOR.alike + FLOOR.significant * error) * quarter:
        yield Floor(float(quarter), error)


def _piece_starts(samples: int) -> list[int]:
    """Return where pieces of a series begin: all, or of a long one as many as fit in memory, evenly."""
    starts = np.arange(0, samples - FLOOR.differences, FLOOR.piece)
    return [int(first) for first in _thinned(starts, FLOOR.piece)]


def _window_power(y: Series, first: int, rejected: IntArray | None) -> FloatArray:
    """Return the mean square of the differences in each window of a piece that holds no rejected sample.

    They are scaled so that white noise keeps its power.
    """
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


def _with_enough_whole(lengths: list[int], samples: int, rejected: IntArray | None) -> list[int]:
    """Return the lengths of which enough segments hold no rejected sample; shorter ones between frequent gaps."""
    if rejected is None or not rejected.size:
        return lengths
    counted = np.diff(np.concatenate([[-1], rejected, [samples]])) - 1
    return [n for n in (*lengths, *FLOOR.between_gaps) if np.sum(counted[counted >= n] // n) >= FLOOR.enough] or lengths


def _thinned(kept: IntArray, hop: int) -> IntArray:
    """Return segments that lie evenly, of more than a series in memory has as many as that."""
    most = max(stored.IN_MEMORY // hop, 1)
    return kept[np.linspace(0, kept.size - 1, most).astype(np.int64)] if kept.size > most else kept


def _whole(segments: int, length: int, rejected: IntArray | None) -> IntArray:
    """Return the segments that hold no rejected sample; all of them where none is left."""
    numbers = np.arange(segments)
    if rejected is None or not rejected.size:
        return numbers
    starts = numbers * max(length // 2, 1)
    whole = np.searchsorted(rejected, starts) == np.searchsorted(rejected, starts + length)
    return numbers[whole] if whole.any() else numbers


def _power(y: Series, starts: IntArray, length: int, band: BoolArray) -> FloatArray:
    """Return the power in the `band` of segments from `starts` on under a Hann window, shape (segments, bins).

    White noise of standard deviation s gives s^2 on average in every bin.
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
    """Return the floor of bins whose power has a chi-square distribution with two degrees of freedom.

    Its median is ln 2 of its mean, and the median of n independent ones has the relative standard
    error 1 / (ln 2 sqrt(n)). A band of a share w of the Nyquist frequency in N samples has
    N w / 2 independent ones, overlap and window notwithstanding.
    """
    return Floor(float(np.median(power)) / math.log(2.0), 1.0 / (math.log(2.0) * math.sqrt(independent)))
