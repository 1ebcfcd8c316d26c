"""Unit of a time column without a stated unit: seconds, unless its numbers must be dates.

Spreadsheets store dates in days, so that a record at 100 Hz appears to have 8.6 MHz; other programs store milliseconds
or nanoseconds since 1970. If the numbers are unambiguous, the column is converted and a treatment is noted in the
record; if they merely exclude seconds, it is rejected.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.records.clock import last_digit, sample_at
from mechid.records.columns import ChosenColumn
from mechid.records.settings import STAMPS
from mechid.records.spec import RecordSpec
from mechid.records.table import Table, column_label
from mechid.signal.series import Series

DAY_S = 86400.0


@dataclass(frozen=True)
class Calendar:
    """Numeric representation of dates: range of numbers from about 1980 to 2080, and unit in s."""

    name: str
    first: float
    last: float
    unit: str
    unit_s: float

    def explains(self, usual: float, mean: float) -> bool:
        """Return whether numbers in this range with given usual and mean intervals must be dates."""
        if self.unit_s < 1.0:
            return True
        # Seconds may have values in the range of days, but not at a rate above a kilohertz that is round in days.
        return mean * STAMPS.fast_for_days_hz < 1.0 and (
            _is_round(usual * self.unit_s) or _is_round(mean * self.unit_s)
        )


CALENDARS = (
    Calendar("a spreadsheet's serial dates or modified Julian dates", 28000.0, 80000.0, "days", DAY_S),
    Calendar("MATLAB's datenum", 723000.0, 760000.0, "days", DAY_S),
    Calendar("Julian dates", 2444000.0, 2481000.0, "days", DAY_S),
    Calendar("time since 1970", 1e12, 3.5e12, "milliseconds", 1e-3),
    Calendar("time since 1970", 1e15, 3.5e15, "microseconds", 1e-6),
    Calendar("Windows' FILETIME", 1.2e17, 1.6e17, "units of 100 ns", 1e-7),
    Calendar(".NET's ticks", 6.2e17, 6.6e17, "units of 100 ns", 1e-7),
    Calendar("time since 1970", 1e18, 3.5e18, "nanoseconds", 1e-9),
)


@dataclass(frozen=True)
class TimeUnit:
    """Conversion of the numbers of a time column to record time: (number - origin) * scale.

    Parameters
    ----------
    scale : float
        Unit of the column in s.
    origin : float
        Number at record time 0.
    rounding_s : float
        Rounding error in s of numbers in the column's unit.
    treatment : Mapping or None
        Description of the conversion, if the column does not state its unit.
    """

    scale: float
    origin: float = 0.0
    rounding_s: float = 0.0
    treatment: Mapping[str, Any] | None = None

    def seconds(self, numbers: FloatArray) -> FloatArray:
        """Return record times in s, (N,)."""
        return (numbers - self.origin) * self.scale if self.origin else numbers * self.scale


def time_unit(table: Table, time: ChosenColumn, spec: RecordSpec, stamps: Series) -> TimeUnit:
    """Return the unit of a time column; `stamps` are its numbers from the first row on, in any unit.

    Raises
    ------
    RecordError
        The column states no unit, and its numbers are neither seconds nor clearly dates; or it states seconds, but the
        numbers are dates.
    """
    stated = table.columns[time.index].stated_unit
    as_stated = TimeUnit(time.scale, rounding_s=_rounding_error(stamps, time.scale))
    if stamps.size < 2 or time.scale != 1.0 or (spec.time is not None and spec.time.unit):
        # The unit is not seconds, or is declared by the campaign.
        return as_stated
    start = sample_at(stamps, 0)
    usual = float(np.median(np.diff(stamps[: STAMPS.most_stamps])))
    mean = (sample_at(stamps, stamps.size - 1) - start) / (stamps.size - 1)
    if not (mean > 0.0 and np.isfinite(start)):
        # The faulty clock is reported when it is read.
        return as_stated
    label = column_label(table.columns, time.index)
    calendar = next((one for one in CALENDARS if one.first <= start <= one.last), None)
    if calendar is None or not calendar.explains(usual, mean):
        if stated is None:
            _refuse_fast(table, label, mean, calendar)
        return as_stated
    if stated is not None:
        raise table.error(
            f'{label}: says "{stated}", but {start:.12g} and the next numbers are {calendar.unit} ({calendar.name}); '
            "correct the header"
        )
    text = (
        f"{label}: read as {calendar.unit} ({calendar.name}) from its numbers, since it states no unit; record time 0 "
        f"is its first number, {start:.14g}"
    )
    treatment = {"step": "time_unit", "text": text, "unit_s": calendar.unit_s, "origin": start}
    return TimeUnit(calendar.unit_s, start, _rounding_error(stamps, calendar.unit_s), treatment)


def _rounding_error(stamps: Series, unit_s: float) -> float:
    """Return the rounding error in s of stamps in a unit; `read_clock` itself detects decimal digits of seconds."""
    if unit_s == 1.0 or not stamps.size:
        return 0.0
    spacing = float(np.spacing(np.abs([sample_at(stamps, 0), sample_at(stamps, stamps.size - 1)]).max()))
    power = float(np.log10(unit_s))
    # In units that are powers of ten the decimal digits remain such in seconds, where read_clock detects them.
    digit = 0.0 if abs(power - round(power)) < 1e-9 else last_digit(stamps, STAMPS.most_digits)
    return unit_s * max(digit, 2.0 * spacing)


def _refuse_fast(table: Table, label: str, interval_s: float, calendar: Calendar | None) -> None:
    """Raise an error for numbers without a unit that are too fast for seconds; possible dates have a lower limit."""
    if interval_s * (STAMPS.fastest_from_date_hz if calendar else STAMPS.fastest_hz) >= 1.0 - STAMPS.round_rate:
        return
    example = "d" if calendar else "ms"
    perhaps = f"; are they {calendar.unit} ({calendar.name})?" if calendar else ";"
    raise table.error(
        f"{label}: as seconds its numbers are {1.0 / interval_s:.4g} Hz, faster than torque is recorded{perhaps} state "
        f'its unit, in the header as in "time [{example}]" or as time = {{ column = ..., unit = "{example}" }}'
    )


def _is_round(interval_s: float) -> bool:
    """Return whether a sample interval, or its rate, is a whole number."""
    if interval_s <= 0.0:
        return False
    number = max(interval_s, 1.0 / interval_s)
    return abs(number / round(number) - 1.0) < STAMPS.round_rate
