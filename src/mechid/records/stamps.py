"""Time stamps that are not regular: a regular clock behind late stamps, or samples that are irregular."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechid.records.clock import whole_rate
from mechid.records.table import Clock, FloatArray, Table

MOST_JITTER = 0.5
"""Sample intervals that a stamp may be off a regular clock: beyond, its sample cannot be told."""
FIRST_STAMPS = 512
"""So many stamps the search for the interval begins with; it grows from there."""
REFITS = 3
"""Lines fitted before it grows, each to places told by the line before."""
RANGE, TRIALS = 0.1, 1001
"""Relative distance from the median interval, and trials in it, where the interval is looked for."""
GAP = 2.5
"""Median intervals between two stamps beyond which samples are missing between them."""
MEND = "window_s cuts a part out"


@dataclass(frozen=True, eq=False)
class Placement:
    """Where samples lie on a regular clock.

    Parameters
    ----------
    clock : Clock
    index : ndarray of int, shape (N,)
        Place of each sample of the file on it, increasing; missing places are missing samples.
    jitter_rms_s, jitter_max_s : float
        How far the stamps are off it.
    """

    clock: Clock
    index: NDArray[np.int64]
    jitter_rms_s: float
    jitter_max_s: float

    @property
    def samples(self) -> int:
        """Number of instants, those without a sample included."""
        return int(self.index[-1]) + 1

    def spread(self, data: FloatArray) -> FloatArray:
        """Return the samples at their places, NaN where there is none."""
        if self.samples == data.size:
            return data
        spread = np.full(self.samples, np.nan)
        spread[self.index] = data
        return spread


def placed(table: Table, time: FloatArray, rate_hz: float | None, first: int = 0) -> Placement:
    """Return the regular clock nearest to jittered stamps, in the sense of least squares.

    Parameters
    ----------
    table : Table
        Where the stamps come from, for messages.
    time : ndarray, shape (N,)
        Stamps in s, increasing, N at least 2.
    rate_hz : float or None
        The rate where it is known; else it is fitted.
    first : int
        Row of the file that the first stamp stands in.

    Raises
    ------
    RecordError
        A stamp is off by half an interval or more, so that its place cannot be told.
    """
    start, interval = _comb(time[:FIRST_STAMPS], rate_hz)
    used = min(FIRST_STAMPS, time.size)
    while True:  # each line tells the places of some more stamps
        for _ in range(REFITS):
            index = np.rint((time[:used] - start) / interval).astype(np.int64)
            start, interval = _line(index, time[:used], None if rate_hz is None else interval)
        if used == time.size:
            break
        used = min(used + used // 4, time.size)
    index = np.rint((time - start) / interval).astype(np.int64)
    off = time - (start + interval * index)
    worst = int(np.argmax(np.abs(off)))
    repeated = np.flatnonzero(np.diff(index) < 1)
    if abs(off[worst]) >= MOST_JITTER * interval or repeated.size:
        row = int(repeated[0]) + 1 if repeated.size else worst
        raise table.error(
            f"the stamp {time[row]:.9g} s is off the nearest regular clock, {1.0 / interval:.9g} Hz, by "
            f"{abs(off[row]):.3g} s, too far to place its sample; if samples were recorded at irregular times, "
            f'write time_stamps = "resample"; {MEND}',
            first + row,
        )
    clock = Clock(start + interval * float(index[0]), rate_hz or whole_rate(1.0 / interval))
    rms = float(np.sqrt(np.mean(off**2)))
    return Placement(clock, index - index[0], rms, float(abs(off[worst])))


def resampled_clock(time: FloatArray, rate_hz: float | None) -> tuple[Clock, int]:
    """Return the clock that irregular samples are interpolated onto, and its number of samples.

    It begins at the first stamp; its rate, where the campaign states none, is that of the median interval.
    """
    rate = rate_hz or whole_rate(1.0 / float(np.median(np.diff(time))), 1e-3)
    return Clock(float(time[0]), rate), int((time[-1] - time[0]) * rate * (1.0 + 1e-12)) + 1


def resampled(time: FloatArray, data: FloatArray, clock: Clock, samples: int) -> FloatArray:
    """Return samples at the instants of `clock`, by the cubic spline through those at `time`.

    NaN in a gap, where the stamps on both sides are more than 2.5 median intervals apart. Interpolation does
    not keep noise, nor signal above a third of the rate, as they were.
    """
    from scipy.interpolate import make_interp_spline

    good = np.isfinite(data)
    instants = clock.start_s + np.arange(samples) / clock.rate_hz
    out = np.asarray(make_interp_spline(time[good], data[good])(instants), dtype=np.float64)
    kept = time[good]
    after = np.clip(np.searchsorted(kept, instants), 1, kept.size - 1)
    wide = kept[after] - kept[after - 1] > GAP * float(np.median(np.diff(time)))
    between = (instants > kept[after - 1]) & (instants < kept[after])
    out[wide & between] = np.nan
    return out


def _comb(time: FloatArray, rate_hz: float | None) -> tuple[float, float]:
    """Return start and interval of the comb that the stamps fit best: the largest |sum exp(2 pi i t / h)|."""
    median = float(np.median(np.diff(time)))
    trials = np.array([1.0 / rate_hz]) if rate_hz else median * np.linspace(1.0 - RANGE, 1.0 + RANGE, TRIALS)
    resultants = np.exp(2j * np.pi * (time - time[0])[:, None] / trials).sum(axis=0)
    best = int(np.argmax(np.abs(resultants)))
    interval = float(trials[best])
    return float(time[0]) + interval * float(np.angle(resultants[best])) / (2.0 * np.pi), interval


def _line(index: NDArray[np.int64], time: FloatArray, interval: float | None) -> tuple[float, float]:
    """Return start and interval of the least-squares line through the stamps."""
    middle = float(index.mean())
    if interval is None:
        centred = index - middle
        interval = float(centred @ (time - time.mean()) / (centred @ centred))
    return float(time.mean()) - interval * middle, interval
