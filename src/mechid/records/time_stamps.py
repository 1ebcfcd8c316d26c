"""Treatment of irregular time stamps: fit of a regular clock to jittered stamps, or resampling of irregular samples."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.records.clock import round_rate, sample_at
from mechid.records.settings import STAMPS
from mechid.records.table import Clock, Table
from mechid.signal.moments import mean
from mechid.signal.series import Series, stretch_of
from mechid.signal.stored_series import WritableSeries, allocate_series, pieces_of

REMEDY = "window_s cuts a part out"


@dataclass(frozen=True)
class Comb:
    """Instants start + k interval, in s."""

    start_s: float
    interval_s: float

    def nearest(self, time: FloatArray) -> IntArray:
        """Return the index of the instant nearest to each stamp, (n,)."""
        return np.rint((time - self.start_s) / self.interval_s).astype(np.int64)


@dataclass(frozen=True, eq=False)
class Placement:
    """Placement of samples on a regular clock.

    Parameters
    ----------
    clock : Clock
    time : Series of N samples
        Stamps in s.
    comb : Comb
        Instants of the clock.
    jitter_rms_s, jitter_max_s : float
        RMS and maximum deviation of the stamps.
    """

    clock: Clock
    time: Series
    comb: Comb
    jitter_rms_s: float
    jitter_max_s: float

    @property
    def samples(self) -> int:
        """Number of instants, including those without a sample."""
        return int(self.places(slice(self.time.size - 1, self.time.size))[0]) + 1

    def places(self, part: slice) -> IntArray:
        """Return the positions of samples of the file on the clock, (n,) increasing."""
        return self.comb.nearest(self.time[part]) - self.comb.nearest(self.time[0:1])

    def spread(self, data: WritableSeries) -> WritableSeries:
        """Return the samples at their positions on the clock, with NaN for missing ones."""
        if self.samples == data.size:
            return data
        out, done = allocate_series(self.samples), 0
        for part in pieces_of(data):
            index = self.places(part)
            values = np.full(int(index[-1]) + 1 - done, np.nan)
            values[index - done] = data[part]
            out[done : done + values.size] = values
            done += values.size
        return out


def fit_regular_clock(table: Table, time: Series, rate_hz: float | None, first: int = 0) -> Placement:
    """Fit a regular clock to jittered stamps by least squares.

    Parameters
    ----------
    table : Table
        Table of the stamps, for messages.
    time : Series of N samples
        Stamps in s, increasing, N at least 2.
    rate_hz : float or None
        Rate if it is known; otherwise it is fitted.
    first : int
        Row of the first stamp in the file.

    Raises
    ------
    RecordError
        A stamp deviates by half an interval or more, so that its position is ambiguous.
    """
    comb = _find_comb(time[: STAMPS.first_stamps], rate_hz)
    used = min(STAMPS.first_stamps, time.size)
    # The interval is known only approximately at first: each fit is accurate enough to place some more stamps, until
    # all are used. Fitting all at once would misplace the stamps far from the start.
    while True:
        for _ in range(STAMPS.refits):
            comb = _fit_line(comb, stretch_of(time, 0, used), held=rate_hz is not None)
        if used == time.size:
            break
        used = min(used + used // 4, time.size)
    rms, row = _jitter(comb, time)
    interval = comb.interval_s
    off = float(_deviation(comb, time, slice(row, row + 1))[0])
    if off >= STAMPS.most_jitter * interval or _is_repeated(comb, time, row):
        raise table.error(
            f"the stamp {sample_at(time, row):.9g} s is off the nearest regular clock, {1.0 / interval:.9g} Hz, by "
            f"{off:.3g} s, too far to place its sample; if samples were recorded at irregular times, "
            f'write time_stamps = "resample"; {REMEDY}',
            first + row,
        )
    begins = comb.start_s + interval * float(comb.nearest(time[0:1])[0])
    found = Placement(Clock(begins, rate_hz or round_rate(1.0 / interval)), time, comb, rms, off)
    refuse_mostly_missing(table, time, found.samples)
    return found


def refuse_mostly_missing(table: Table, time: Series, instants: float) -> None:
    """Raise RecordError if a clock has far more instants than there are stamps, which means that a stamp is wrong."""
    if instants > max(STAMPS.most_missing * time.size, STAMPS.always_placed):
        raise table.error(
            f"{time.size} time stamps from {sample_at(time, 0):.9g} s to {sample_at(time, time.size - 1):.9g} s are "
            f"{instants:.3g} samples on a regular clock; is a stamp wrong? {REMEDY}"
        )


def _deviation(comb: Comb, time: Series, part: slice) -> FloatArray:
    """Return the deviation of stamps from their instants, (n,) s."""
    stamps = time[part]
    return np.asarray(np.abs(stamps - (comb.start_s + comb.interval_s * comb.nearest(stamps))), dtype=np.float64)


def _jitter(comb: Comb, time: Series) -> tuple[float, int]:
    """Return the RMS deviation of stamps in s, and the index of the first repeated stamp or of the worst one."""
    squares, worst, largest = 0.0, 0, -1.0
    for part in pieces_of(time):
        off = _deviation(comb, time, part)
        squares += float(np.sum(off**2))
        if off.max() > largest:
            worst, largest = part.start + int(np.argmax(off)), float(off.max())
    # Two samples at the same position are worse than any deviation: no clock of this rate can hold both.
    for part in pieces_of(time):
        first = max(part.start, 1)
        repeated = np.flatnonzero(np.diff(comb.nearest(time[first - 1 : part.stop])) < 1)
        if repeated.size:
            worst = first + int(repeated[0])
            break
    return math.sqrt(squares / time.size), worst


def _is_repeated(comb: Comb, time: Series, row: int) -> bool:
    """Return whether a stamp has the same position as its predecessor, or an earlier one."""
    return bool(np.any(np.diff(comb.nearest(time[max(row - 1, 0) : row + 1])) < 1))


def resampling_clock(table: Table, time: FloatArray, rate_hz: float | None) -> tuple[Clock, int]:
    """Return the clock onto which irregular samples are interpolated, and its number of samples.

    The clock begins at the first stamp. If the campaign states no rate, it is that of the median interval.

    Raises
    ------
    RecordError
        Nearly all samples would be missing.
    """
    rate = rate_hz or round_rate(1.0 / float(np.median(np.diff(time))), 1e-3)
    instants = float((time[-1] - time[0]) * rate * (1.0 + 1e-12))
    refuse_mostly_missing(table, time, instants)
    return Clock(float(time[0]), rate), int(instants) + 1


def resample(time: FloatArray, data: FloatArray, clock: Clock, samples: int) -> FloatArray:
    """Return samples at the instants of `clock`, from the cubic spline through those at `time`.

    Samples in gaps, where adjacent stamps are more than 2.5 median intervals apart, are NaN. Interpolation alters
    noise, and signals above a third of the rate.

    Raises
    ------
    numpy.linalg.LinAlgError
        Intervals differ by more than floating point can resolve.
    """
    from scipy.interpolate import make_interp_spline

    good = np.isfinite(data)
    instants = clock.start_s + np.arange(samples) / clock.rate_hz
    out = np.asarray(make_interp_spline(time[good], data[good])(instants), dtype=np.float64)
    kept = time[good]
    after = np.clip(np.searchsorted(kept, instants), 1, kept.size - 1)
    wide = kept[after] - kept[after - 1] > STAMPS.gap * float(np.median(np.diff(time)))
    between = (instants > kept[after - 1]) & (instants < kept[after])
    out[wide & between] = np.nan
    return out


def _find_comb(time: FloatArray, rate_hz: float | None) -> Comb:
    """Return the comb that fits the stamps best, with the largest |sum exp(2 pi i t / h)|."""
    median = float(np.median(np.diff(time)))
    trials = (
        np.array([1.0 / rate_hz])
        if rate_hz
        else median * np.linspace(1.0 - STAMPS.interval_range, 1.0 + STAMPS.interval_range, STAMPS.interval_trials)
    )
    # The phases of all stamps add up coherently only for the right interval.
    resultants = np.exp(2j * np.pi * (time - time[0])[:, None] / trials).sum(axis=0)
    best = int(np.argmax(np.abs(resultants)))
    interval = float(trials[best])
    return Comb(float(time[0]) + interval * float(np.angle(resultants[best])) / (2.0 * np.pi), interval)


def _fit_line(comb: Comb, time: Series, *, held: bool) -> Comb:
    """Fit a line to the stamps at their positions on a comb by least squares; with `held`, its interval is fixed."""
    middle = sum(float(comb.nearest(time[part]).sum()) for part in pieces_of(time)) / time.size
    mean_s, interval = mean(time), comb.interval_s
    if not held:
        product = square = 0.0
        for part in pieces_of(time):
            centred = comb.nearest(time[part]) - middle
            product += float(centred @ (time[part] - mean_s))
            square += float(centred @ centred)
        interval = product / square
    return Comb(mean_s - interval * middle, interval)
