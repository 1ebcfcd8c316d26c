"""Clock of a record, with one start and one rate, determined from regular time stamps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.records.settings import STAMPS
from mechid.records.table import Clock, Table
from mechid.signal.series import Series

BLOCK = 65536


def refuse_implausible_clock(table: Table, clock: Clock) -> None:
    """Raise RecordError if the rate or the start of a clock is implausible for any recorder."""
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
    """Return the clock of regular time stamps.

    Parameters
    ----------
    table : Table
        Table of the stamps, for messages.
    time : Series of N samples
        Time stamps in s, finite.
    rate_hz : float or None
        Rate stated by the campaign; the stamps must agree with it within half an interval.
    first : int
        Row of the first stamp in the file, for messages.
    rounding_s : float
        Rounding error of stamps that were converted from another unit.

    Raises
    ------
    RecordError
        There are fewer than two stamps; or the clock goes back, repeats, is irregular, or contradicts `rate_hz`.
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
    # Stamps printed with few digits may deviate more than regular ones, but only by a fraction of an interval.
    unresolved = max(_printed_rounding(time, interval), _binary_rounding(time), rounding_s)
    allowed = max(STAMPS.jitter * interval, min(unresolved, STAMPS.jitter_of_rounded * interval))
    _refuse_jitter(table, time, interval, allowed, first)
    return Clock(sample_at(time, 0), _mean_rate(time, allowed, rounding_s))


def refuse_row_numbers(table: Table, time: Series, label: str) -> None:
    """Raise RecordError if stamps without a unit increase by exactly 1, like row numbers and unlike most clocks."""
    if time.size > 1 and _first_row(time, lambda start, stop: np.diff(time[start : stop + 1]) != 1.0) is None:
        raise table.error(
            f"{label}: rises by exactly 1 from row to row and states no unit: row numbers, or seconds? if it counts "
            "rows, give the sample rate (sample_rate_hz, or --sample-rate-hz of look) and name the torque's column; if "
            'these are seconds, write time = { column = ..., unit = "s" }'
        )


def sample_at(series: Series, number: int) -> float:
    """Return the sample at an index."""
    return float(series[number : number + 1][0])


def _span(time: Series) -> float:
    """Return the time from the first to the last stamp in s."""
    return sample_at(time, time.size - 1) - sample_at(time, 0)


def refuse_not_increasing(table: Table, time: Series, first: int = 0) -> None:
    """Raise RecordError if the clock goes back or repeats; `first` is the row of the first stamp."""
    _refuse_backward(table, time, first)
    _refuse_repeated(table, time, first)


def _mean_rate(time: Series, allowed: float, rounding_s: float) -> float:
    """Return the mean rate, rounded to a whole number of hertz within the accuracy of the stamps."""
    span = _span(time)
    near = max(min(STAMPS.whole_rate, allowed / span), _binary_rounding(time) / span, 2.0 * rounding_s / span)
    return round_rate((time.size - 1) / span, near)


def round_rate(rate_hz: float, near: float = STAMPS.whole_rate) -> float:
    """Return a rate rounded to a whole number of hertz if it is within the relative tolerance `near`."""
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
    """Raise RecordError if stamps deviate from a regular clock by more than `allowed`."""
    if _first_row(time, lambda start, stop: _deviation(time, interval, start, stop) > allowed) is None:
        return
    # A gap makes the mean interval wrong, so that every stamp deviates: the message names the most unusual step.
    usual = float(np.median(np.diff(time[: STAMPS.most_stamps])))

    def odd(start: int, stop: int) -> FloatArray:
        return np.abs(np.diff(time[start : stop + 1]) - usual)

    most = max(float(odd(start, start + BLOCK).max()) for start in range(0, time.size - 1, BLOCK))
    # Slightly below the maximum: of several equal steps, which differ by rounding, the first one is named.
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
    """Return the floating-point rounding error of stamps in s, which is large for seconds of a calendar."""
    return 4.0 * float(np.spacing([abs(sample_at(time, 0)), abs(sample_at(time, time.size - 1))]).max())


def _printed_rounding(time: Series, interval: float) -> float:
    """Return the rounding error in s of stamps printed with few digits.

    It is zero if the interval is a multiple of the last digit, from the first stamp to the last.
    """
    digit = last_digit(time)
    multiple = interval / digit if digit else 0.0
    # If the interval is a multiple of the last digit, printing it loses nothing, however long the record is.
    return 0.0 if abs(multiple - round(multiple)) * time.size < 1e-3 else 1.001 * digit


def last_digit(numbers: Series, most: int = 9) -> float:
    """Return the power of ten of which numbers are multiples; 0 if it is below 10**-most or cannot be determined."""
    some = np.concatenate((numbers[:1000], numbers[max(numbers.size - 1000, 0) :]))
    spacing = 2.0 * float(np.spacing(np.abs(some).max()))
    for digits in range(most + 1):
        scaled = (some - some[0]) * 10.0**digits
        # A date leaves few digits of a float for the time of day.
        near = max(1e-3, spacing * 10.0**digits)
        if near > STAMPS.most_rounded:
            break
        if np.all(np.abs(scaled - np.rint(scaled)) < near):
            return float(10.0**-digits)
    return 0.0


def _first_row(time: Series, bad: Callable[[int, int], BoolArray]) -> int | None:
    """Return the first row at which `bad(start, stop)` is true, searching block by block, or None."""
    for start in range(0, time.size, BLOCK):
        rows = np.flatnonzero(bad(start, min(start + BLOCK, time.size)))
        if rows.size:
            return start + int(rows[0])
    return None
