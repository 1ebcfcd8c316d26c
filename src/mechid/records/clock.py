"""The clock of a record: one start and one rate, once the time stamps are proved regular."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.records.settings import STAMPS
from mechid.records.table import Clock, Table
from mechid.signal.series import Series

BLOCK = 65536


def refuse_implausible_clock(table: Table, clock: Clock) -> None:
    """Raise RecordError where a clock, wherever it is from, is none that a recorder has."""
    if not (
        1.0 / STAMPS.longest_s <= clock.rate_hz <= 1.0 / STAMPS.shortest_s and abs(clock.start_s) <= STAMPS.longest_s
    ):
        raise table.error(
            f"{clock.rate_hz:.9g} Hz from {clock.start_s:.9g} s is no recorder's clock; check the stamps' unit, or "
            "sample_rate_hz"
        )


def read_clock(
    table: Table, time: Series, rate_hz: float | None = None, first: int = 0, *, rounding_s: float = 0.0
) -> Clock:
    """Return the clock that the time stamps follow.

    Parameters
    ----------
    table : Table
        Where the stamps come from, for messages.
    time : Series of N samples
        Time stamps in s, finite.
    rate_hz : float or None
        Rate that the campaign states; the stamps have to agree with it to half an interval.
    first : int
        Row of the file that the first stamp stands in, for messages.
    rounding_s : float
        How far stamps that were converted from another unit may be off by their digits there.

    Raises
    ------
    RecordError
        There are less than two stamps; or the clock goes back, repeats, is irregular, or contradicts `rate_hz`.
    """
    if time.size < 2:
        raise table.error(f"{time.size} time stamps; a clock needs two at least")
    _refuse_backward(table, time, first)
    if rate_hz is not None:
        refuse_implausible_clock(table, Clock(0.0, rate_hz))
        _refuse_contradiction(table, time, rate_hz, first, rounding_s)
        return Clock(sample_at(time, 0), rate_hz)
    _refuse_repeated(table, time, first)
    interval = _span(time) / (time.size - 1)
    if not STAMPS.shortest_s <= interval <= STAMPS.longest_s:
        raise table.error(f"its time stamps lie {interval:.3g} s apart on the average; is their unit right?")
    unresolved = max(_printed_rounding(time, interval), _binary_rounding(time), rounding_s)
    allowed = max(STAMPS.jitter * interval, min(unresolved, STAMPS.jitter_of_rounded * interval))
    _refuse_jitter(table, time, interval, allowed, first)
    return Clock(sample_at(time, 0), _mean_rate(time, allowed, rounding_s))


def refuse_row_numbers(table: Table, time: Series, label: str) -> None:
    """Raise RecordError where stamps without a unit rise by exactly 1: row numbers look so, and clocks hardly ever."""
    if time.size > 1 and _first_row(time, lambda start, stop: np.diff(time[start : stop + 1]) != 1.0) is None:
        raise table.error(
            f"{label}: rises by exactly 1 from row to row and states no unit: row numbers, or seconds? if it counts "
            "rows, give the sample rate (sample_rate_hz, or --sample-rate-hz of look) and name the torque's column; if "
            'these are seconds, write time = { column = ..., unit = "s" }'
        )


def sample_at(series: Series, number: int) -> float:
    """Return one sample."""
    return float(series[number : number + 1][0])


def _span(time: Series) -> float:
    """Return the time from the first stamp to the last, s."""
    return sample_at(time, time.size - 1) - sample_at(time, 0)


def refuse_not_increasing(table: Table, time: Series, first: int = 0) -> None:
    """Raise RecordError where the clock goes back or repeats; `first` is the row of the first stamp."""
    _refuse_backward(table, time, first)
    _refuse_repeated(table, time, first)


def _mean_rate(time: Series, allowed: float, rounding_s: float) -> float:
    """Return the mean rate, or the whole number of hertz that is all but the same."""
    span = _span(time)
    near = max(min(STAMPS.whole_rate, allowed / span), _binary_rounding(time) / span, 2.0 * rounding_s / span)
    return round_rate((time.size - 1) / span, near)


def round_rate(rate_hz: float, near: float = STAMPS.whole_rate) -> float:
    """Return the whole number of hertz that a rate is all but the same as, else the rate."""
    whole = round(rate_hz)
    return float(whole) if whole > 0 and abs(rate_hz / whole - 1.0) <= near else rate_hz


def _refuse_backward(table: Table, time: Series, first: int) -> None:
    row = _first_row(time, lambda start, stop: np.diff(time[start : stop + 1]) < 0.0)
    if row is not None:
        raise table.error(
            f"the clock goes back, from {sample_at(time, row):.9g} s to {sample_at(time, row + 1):.9g} s; "
            "is another column the time?",
            first + row + 1,
        )


def _refuse_repeated(table: Table, time: Series, first: int) -> None:
    row = _first_row(time, lambda start, stop: np.diff(time[start : stop + 1]) == 0.0)
    if row is not None:
        raise table.error(
            f"the time stamp {sample_at(time, row):.9g} s is repeated; if the stamps have too few digits, "
            "give sample_rate_hz and name the channels",
            first + row + 1,
        )


def _refuse_jitter(table: Table, time: Series, interval: float, allowed: float, first: int) -> None:
    """Name the oddest step: with a gap the mean interval is wrong, so every stamp is off."""
    if _first_row(time, lambda start, stop: _deviation(time, interval, start, stop) > allowed) is None:
        return
    usual = float(np.median(np.diff(time[: STAMPS.most_stamps])))

    def odd(start: int, stop: int) -> FloatArray:
        return np.abs(np.diff(time[start : stop + 1]) - usual)

    most = max(float(odd(start, start + BLOCK).max()) for start in range(0, time.size - 1, BLOCK))
    row = (_first_row(time, lambda start, stop: odd(start, stop) > 0.99 * most) or 0) + 1
    step = sample_at(time, row) - sample_at(time, row - 1)
    raise table.error(
        f"irregular time: {sample_at(time, row):.9g} s comes {step:.6g} s after the stamp before it, mostly "
        f"it is {usual:.6g} s; declare time_stamps or window_s in its conditioning; if the stamps have too few digits, "
        "give sample_rate_hz and name the channels",
        first + row,
    )


def _refuse_contradiction(table: Table, time: Series, rate_hz: float, first: int, rounding_s: float) -> None:
    interval = 1.0 / rate_hz
    allowed = max(0.5 * interval, _printed_rounding(time, interval), rounding_s)
    row = _first_row(time, lambda start, stop: _deviation(time, interval, start, stop) > allowed)
    if row is not None:
        raise table.error(
            f"sample_rate_hz = {rate_hz:.9g} contradicts the time column: {sample_at(time, row):.9g} s "
            f"where it gives {sample_at(time, 0) + row * interval:.9g} s",
            first + row,
        )


def _deviation(time: Series, interval: float, start: int, stop: int) -> FloatArray:
    """Return |t_k - (t_0 + k h)| in s for k from `start` to `stop`, shape (stop - start,)."""
    regular = sample_at(time, 0) + interval * np.arange(start, stop)
    return np.asarray(np.abs(time[start:stop] - regular), dtype=np.float64)


def _binary_rounding(time: Series) -> float:
    """Return how far in s rounding to floating point may move stamps: much, for a calendar's seconds."""
    return 4.0 * float(np.spacing([abs(sample_at(time, 0)), abs(sample_at(time, time.size - 1))]).max())


def _printed_rounding(time: Series, interval: float) -> float:
    """Return how far in s rounding to the printed digits moves stamps of this interval.

    None where the interval is a multiple of the last digit, from the first stamp to the last.
    """
    digit = last_digit(time)
    multiple = interval / digit if digit else 0.0
    return 0.0 if abs(multiple - round(multiple)) * time.size < 1e-3 else 1.001 * digit


def last_digit(numbers: Series, most: int = 9) -> float:
    """Return the power of ten that numbers are multiples of, 0 where it is below 10**-most or not to be told."""
    some = np.concatenate((numbers[:1000], numbers[max(numbers.size - 1000, 0) :]))
    spacing = 2.0 * float(np.spacing(np.abs(some).max()))
    for digits in range(most + 1):
        scaled = (some - some[0]) * 10.0**digits
        near = max(1e-3, spacing * 10.0**digits)  # a date leaves few digits of a floating-point number to its time
        if near > STAMPS.most_rounded:
            break
        if np.all(np.abs(scaled - np.rint(scaled)) < near):
            return float(10.0**-digits)
    return 0.0


def _first_row(time: Series, bad: Callable[[int, int], BoolArray]) -> int | None:
    """Return the first row where `bad(start, stop)` is true, looked for block by block."""
    for start in range(0, time.size, BLOCK):
        rows = np.flatnonzero(bad(start, min(start + BLOCK, time.size)))
        if rows.size:
            return start + int(rows[0])
    return None
