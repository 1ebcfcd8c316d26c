"""Conversion of a file's columns to conditioned samples in SI units on one regular clock."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.errors import RecordError
from mechid.reading.memory import GIB, memory_bytes
from mechid.records.clock import read_clock, refuse_implausible_clock, refuse_not_increasing, refuse_row_numbers
from mechid.records.columns import ChosenColumn, Layout, find_time_column
from mechid.records.conditioning import Samples, apply_limits, condition
from mechid.records.health import refuse_not_finite
from mechid.records.memory import refuse_insufficient_disk
from mechid.records.settings import STAMPS
from mechid.records.spec import RecordSpec, TimeStamps
from mechid.records.table import ALL, Clock, Table, column_label
from mechid.records.time_stamps import fit_regular_clock, resample, resampling_clock
from mechid.records.time_unit import TimeUnit, time_unit
from mechid.signal.series import Series
from mechid.signal.stored_series import (
    WORD,
    SampleBuffer,
    WritableSeries,
    as_writable,
    change_in_place,
    is_long,
    pieces_of,
    stretch_in_place,
)

COPIES = 2
"""Number of copies of a column in memory while it is read."""
GAP_REMEDY = "; max_gap_s = ... allows to bridge missing samples, window_s to leave them out"
MIN_SPLINE_SAMPLES = 4
"""Minimum number of samples of a cubic spline."""


def sample(table: Table, layout: Layout, spec: RecordSpec) -> Samples:
    """Read the layout's columns and condition them.

    Raises
    ------
    RecordError
        The clock is not regular, samples are missing, or a conditioning step cannot be applied.
    """
    how = spec.conditioning
    rows, unit = _rows(table, layout, spec)
    arrays = read_columns(table, [column.index for column in layout.selected_columns], rows)
    if layout.time and unit is None:
        unit = time_unit(table, layout.time, spec, arrays[0])
    # A text file, which is read as a whole.
    if rows == ALL and unit and how.needed_s:
        rows = _rows_within(arrays[0], unit, how.needed_s)
        arrays = [stretch_in_place(values, rows.start, rows.stop) for values in arrays]
    first = rows.start or 0
    _refuse_empty(table, arrays[0])
    channels = arrays[-len(layout.channels) :]
    data = [
        _scale_to_si(table, column, values, first, finite=how.max_gap_s is None)
        for column, values in zip(layout.channels, channels, strict=True)
    ]
    # Limits are in SI units and apply to the scaled samples.
    treatments = apply_limits(layout, how, data)
    if unit:
        if unit.treatment:
            treatments = [unit.treatment, *treatments]
        _convert_to_seconds(table, layout.selected_columns[0], arrays[0], unit, first)
    samples = _place_on_clock(table, layout, spec, unit, arrays, data, first)
    refuse_implausible_clock(table, samples.clock)
    samples = replace(samples, treatments=(*treatments, *samples.treatments))
    return condition(table, layout, how, samples)


def read_columns(table: Table, wanted: Sequence[int], rows: slice = ALL) -> list[WritableSeries]:
    """Read rows of columns in the file's units block by block; long series are stored in temporary files."""
    _refuse_too_large(table, wanted, rows)
    gathered = [SampleBuffer() for _ in wanted]
    for block in table.blocks(wanted, rows):
        for one, part in zip(gathered, block, strict=True):
            one.append(part)
    return [one.series() for one in gathered]


@dataclass(frozen=True)
class Sampling:
    """Sampling of a column.

    Parameters
    ----------
    clock : Clock or None
        Regular clock, if there is one and it is known.
    samples : int or None
        Number of samples.
    irregular_hz : float or None
        Reciprocal of the median interval of irregular stamps.
    fault : str or None
        Reason why there is no regular clock, or why the column cannot be read.
    """

    clock: Clock | None = None
    samples: int | None = None
    irregular_hz: float | None = None
    fault: str | None = None


def samplings(table: Table) -> list[Sampling]:
    """Return the sampling of each column of a file, from its own clock or else from its time column.

    Raises
    ------
    RecordError
        The samples of a column must be counted, but it cannot be read.
    """
    by_time: dict[int, Sampling] = {}
    found = []
    for index, column in enumerate(table.columns):
        time = None if column.fault or column.clock else find_time_column(table, index)
        if time is None:
            found.append(_sampling_without_stamps(table, index))
            continue
        # Many columns may share a time column, whose stamps are examined once.
        if time.index not in by_time:
            by_time[time.index] = _sampling_from_stamps(table, time)
        found.append(by_time[time.index])
    return found


def _sampling_without_stamps(table: Table, index: int) -> Sampling:
    """Return the sampling of a column without time stamps."""
    # Reading the first sample shows whether the column can be read, without the cost of reading all of it.
    column = table.columns[index]
    if column.fault:
        return Sampling(column.clock, column.samples)
    if column.samples is None:
        return Sampling(column.clock, sum(block[0].size for block in table.blocks([index])))
    try:
        table.read([index], slice(0, 1))
    except RecordError as error:
        return Sampling(column.clock, column.samples, fault=str(error))
    return Sampling(column.clock, column.samples)


def _sampling_from_stamps(table: Table, time: ChosenColumn) -> Sampling:
    samples, rate_hz = table.columns[time.index].samples, None
    try:
        stamps = read_columns(table, [time.index])[0]
        unit = time_unit(table, time, RecordSpec(name="", path=""), stamps)
        _convert_to_seconds(table, time, stamps, unit)
        samples, rate_hz = stamps.size, _median_rate(stamps)
        return Sampling(read_clock(table, stamps, rounding_s=unit.rounding_s), samples)
    except RecordError as error:
        return Sampling(None, samples, rate_hz, str(error))


def _median_rate(stamps: Series) -> float | None:
    interval = float(np.median(np.diff(stamps[: STAMPS.most_stamps]))) if stamps.size > 1 else 0.0
    return 1.0 / interval if interval > 0.0 else None


def _refuse_empty(table: Table, data: Series) -> None:
    if data.size < 2:
        raise table.error(f"{data.size} samples in it, or in its window_s; a record needs 16 at least")


def _refuse_too_large(table: Table, wanted: Sequence[int], rows: slice) -> None:
    """Raise an error if samples need more memory or disk space than there is."""
    samples = len(range(table.columns[wanted[0]].samples or 0)[rows])
    if table.is_sliced:
        if is_long(samples):
            refuse_insufficient_disk(table.error, samples, len(wanted))
        return
    needed = WORD * COPIES * samples * len(wanted)
    there = memory_bytes()
    if there is not None and needed > there:
        raise table.error(
            f"{samples} samples of {len(wanted)} columns need {needed / GIB:.3g} GiB of memory, there are "
            f"{there / GIB:.3g} GiB; read a part with window_s"
        )


def _rows(table: Table, layout: Layout, spec: RecordSpec) -> tuple[slice, TimeUnit | None]:
    """Return the rows needed for the window, and the unit of the time column if it was determined for this."""
    needed, samples = spec.conditioning.needed_s, table.columns[layout.channels[0].index].samples
    if needed is None or samples is None:
        return ALL, None
    clock = layout.clock or (Clock(0.0, spec.sample_rate_hz) if spec.sample_rate_hz and not layout.time else None)
    if clock is not None:
        rows = Samples(clock, ()).slice_between(*needed)
        return slice(rows.start, min(rows.stop, samples)), None
    if layout.time is None:
        return ALL, None
    stamps = read_columns(table, [layout.time.index])[0]
    unit = time_unit(table, layout.time, spec, stamps)
    return _rows_within(stamps, unit, needed), unit


def _rows_within(time: Series, unit: TimeUnit, needed_s: tuple[float, float]) -> slice:
    """Return the rows from the first to the last stamp within a time range."""
    ends: list[int] = []
    for part in pieces_of(time):
        seconds = unit.seconds(time[part])
        inside = np.flatnonzero((seconds >= needed_s[0]) & (seconds <= needed_s[1]))
        ends += [part.start + int(inside[0]), part.start + int(inside[-1]) + 1] if inside.size else []
    return slice(ends[0], ends[-1]) if ends else slice(0, 0)


def _scale_to_si(
    table: Table, column: ChosenColumn, data: WritableSeries, first: int, *, finite: bool
) -> WritableSeries:
    """Convert a column's samples to SI units in place and return them."""
    if finite:
        if_missing = "" if column.quantity == "time" else GAP_REMEDY
        refuse_not_finite(table, data, column_label(table.columns, column.index), first, if_missing)
    if column.scale != 1.0:
        change_in_place(data, lambda values, part: values * column.scale)
    return data


def _convert_to_seconds(
    table: Table, column: ChosenColumn, stamps: WritableSeries, unit: TimeUnit, first: int = 0
) -> None:
    """Convert a time column to seconds in place."""
    refuse_not_finite(table, stamps, column_label(table.columns, column.index), first)
    if unit.scale != 1.0 or unit.origin:
        change_in_place(stamps, lambda values, part: unit.seconds(values))


def _place_on_clock(
    table: Table,
    layout: Layout,
    spec: RecordSpec,
    unit: TimeUnit | None,
    arrays: list[WritableSeries],
    data: list[WritableSeries],
    first: int,
) -> Samples:
    """Assign the samples to a regular clock."""
    rate_hz, stamps = spec.sample_rate_hz, spec.conditioning.time_stamps
    if layout.time is None or unit is None:
        return Samples(_known_clock(table, layout, rate_hz, first), tuple(data))
    time = arrays[0]
    if rate_hz is None and table.columns[layout.time.index].stated_unit is None and not (spec.time and spec.time.unit):
        refuse_row_numbers(table, time, column_label(table.columns, layout.time.index))
    if stamps is TimeStamps.STRICT:
        return Samples(read_clock(table, time, rate_hz, first, rounding_s=unit.rounding_s), tuple(data))
    refuse_not_increasing(table, time, first)
    if rate_hz is not None:
        refuse_implausible_clock(table, Clock(0.0, rate_hz))
    if stamps is TimeStamps.REGULAR:
        return _place_on_nearest_clock(table, time, rate_hz, data, first)
    seconds = time[:]
    clock, samples = resampling_clock(table, seconds, rate_hz)
    steps = np.diff(seconds)
    text = (
        f"interpolated by cubic splines from samples {steps.min():.4g} s to {steps.max():.4g} s apart onto "
        f"{clock.rate_hz:.9g} Hz"
    )
    for column, values in zip(layout.channels, data, strict=True):
        known = int(np.count_nonzero(np.isfinite(values[:])))
        if known < MIN_SPLINE_SAMPLES:
            label = column_label(table.columns, column.index)
            raise table.error(
                f"{label}: {known} samples; a cubic spline needs {MIN_SPLINE_SAMPLES}: give a longer record, or leave "
                'time_stamps = "resample" out'
            )
    try:
        spread = tuple(as_writable(resample(seconds, values[:], clock, samples)) for values in data)
    except np.linalg.LinAlgError as error:
        raise table.error(
            f"time stamps from {steps.min():.4g} s to {steps.max():.4g} s apart differ too much for a cubic spline; "
            'check their unit, or leave time_stamps = "resample" out'
        ) from error
    figures = {"shortest_s": float(steps.min()), "longest_s": float(steps.max()), "rate_hz": clock.rate_hz}
    return Samples(clock, ()).with_treatment("time_stamps", text, spread, taken="resample", **figures)


def _place_on_nearest_clock(
    table: Table, time: Series, rate_hz: float | None, data: list[WritableSeries], first: int
) -> Samples:
    found = fit_regular_clock(table, time, rate_hz, first)
    lost = found.samples - time.size
    text = (
        f"time stamps replaced by the nearest regular clock, {found.clock.rate_hz:.9g} Hz: jitter "
        f"{found.jitter_rms_s:.3g} s RMS, {found.jitter_max_s:.3g} s at most; {lost} samples never stamped"
    )
    figures = {"rate_hz": found.clock.rate_hz, "jitter_rms_s": found.jitter_rms_s, "jitter_max_s": found.jitter_max_s}
    spread = tuple(found.spread(values) for values in data)
    return Samples(found.clock, ()).with_treatment(
        "time_stamps", text, spread, taken="regular", lost_samples=lost, **figures
    )


def _known_clock(table: Table, layout: Layout, rate_hz: float | None, first: int) -> Clock:
    """Return the clock stated by file or campaign, starting at the first sample read."""
    clock = layout.clock or (Clock(0.0, rate_hz) if rate_hz else None)
    if clock is None:
        raise table.error("no time column; give sample_rate_hz")
    if rate_hz is not None and abs(rate_hz / clock.rate_hz - 1.0) > 1e-6:
        raise table.error(f"sample_rate_hz = {rate_hz:.9g} contradicts the file, which says {clock.rate_hz:.9g} Hz")
    return replace(clock, start_s=clock.start_s + first / clock.rate_hz)
