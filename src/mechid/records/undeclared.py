"""Reader of files without a declaration: every column that can be a channel is read.

The quantity of a column follows from its unit. A column without a unit keeps its numbers and its name.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mechid.errors import RecordError, UsageError, did_you_mean
from mechid.records.ambiguous_numbers import raw_counts_warning, unapplied_fault
from mechid.records.column_names import is_row_number, is_time
from mechid.records.columns import ChosenColumn, Layout, find_column, find_time_column
from mechid.records.conditioning import Samples
from mechid.records.formats import MIN_SAMPLES, digest_of, open_table, wrap_read_errors
from mechid.records.record import Channel, Record
from mechid.records.sampling import sample
from mechid.records.spec import ChannelSpec, Conditioning, RecordSpec, TimeStamps
from mechid.records.table import Clock, Table, column_label
from mechid.records.time_unit import time_unit
from mechid.signal.moments import extremes
from mechid.signal.series import no_samples
from mechid.units import SI_UNIT, measures, si_unit, to_si_factor

QUANTITY_BY_KIND: Mapping[str, str] = {
    "torque": "torque",
    "force": "force",
    "angle": "output_angle",
    "rate": "output_rate",
    "position": "position",
    "velocity": "velocity",
    "current": "current",
    "voltage": "voltage",
}
"""Representative quantity for each kind of quantity that a unit can identify."""
LARGEST_VALUE = 1e100
MAX_LISTED_COLUMNS = 8
OVERRIDE_REMEDY = "give --column and --unit, that of the numbers as they are stored; in a campaign, unit and gain"
COUNTS = "counts"
"""Unit assigned to integers without a unit."""


@dataclass(frozen=True, kw_only=True)
class Hints:
    """Optional information by the user about the columns of files without a declaration.

    Parameters
    ----------
    sample_rate_hz : float or None
        Sample rate of a file without a clock.
    columns : tuple of str
        Columns to read, by name or by index from 0; empty for all.
    quantity, unit : str or None
        Quantity of the columns, one of `mechid.units.SI_UNIT`, and the unit of the file's numbers.

    Raises
    ------
    UsageError
        The quantity is unknown.
    """

    sample_rate_hz: float | None = None
    columns: tuple[str, ...] = ()
    quantity: str | None = None
    unit: str | None = None

    def __post_init__(self) -> None:
        if self.quantity is not None and self.quantity not in SI_UNIT:
            near = did_you_mean(self.quantity, SI_UNIT) or "; known are " + ", ".join(SI_UNIT)
            raise UsageError(f'unknown quantity "{self.quantity}"{near}')


@dataclass(frozen=True, kw_only=True)
class _Group:
    """Columns with a common clock, and the units of their values."""

    layout: Layout
    units: tuple[str, ...]

    def split(self) -> tuple[_Group, ...]:
        """Return a group for each channel."""
        pairs = zip(self.layout.channels, self.units, strict=True)
        return tuple(_Group(layout=replace(self.layout, channels=(c,)), units=(unit,)) for c, unit in pairs)


def read_bare(path: Path, hints: Hints | None = None) -> tuple[Record, ...]:
    """Read all channels of a file into one record per common clock.

    Missing samples are bridged, and irregular time stamps are replaced by the nearest regular clock; both are noted in
    the treatments. Columns that cannot be channels are listed in the warnings of the first record.

    Parameters
    ----------
    path : Path
    hints : Hints or None

    Raises
    ------
    RecordError
        The file is missing, is not a record, or has no readable channel; the message has one line.
    """
    hints = hints or Hints()
    table = open_table(path, path.name)
    refused: list[str] = []
    with wrap_read_errors(path.name):
        groups = _groups(table, hints, refused)
        records = [record for group in groups for record in _read(path, table, group, hints, refused)]
    refused += _omitted_columns_warning(table, hints)
    if not records:
        raise RecordError(refused[0] if refused else str(table.error("no column that can be a channel")))
    warnings = (*table.warnings, *refused, *_raw_count_warnings(table, groups, hints), *records[0].warnings)
    return (replace(records[0], warnings=warnings), *records[1:])


def _omitted_columns_warning(table: Table, hints: Hints) -> list[str]:
    """Return a one-line warning about the columns that are not read; empty if all are, or if some were selected."""
    named = [] if hints.columns else [k for k in range(len(table.columns)) if _find_fault(table, k, hints)]
    said = [f"{column_label(table.columns, k)}: {_find_fault(table, k, hints)}" for k in named[:MAX_LISTED_COLUMNS]]
    more = [f"{len(named) - MAX_LISTED_COLUMNS} more"] if len(named) > MAX_LISTED_COLUMNS else []
    return [str(table.error("; ".join([*said, *more])))] if named else []


def _find_fault(table: Table, index: int, hints: Hints) -> str | None:
    """Return the reason why a column is not read, or None."""
    column = table.columns[index]
    if column.fault or hints.unit is not None:
        return column.fault
    return unapplied_fault(table, index, OVERRIDE_REMEDY)


def _raw_count_warnings(table: Table, groups: Sequence[_Group], hints: Hints) -> list[str]:
    """Return warnings about integers that are read in the file's unit but may be raw counts."""
    read = [chosen for group in groups for chosen in group.layout.channels if table.columns[chosen.index].stated_unit]
    specs = (ChannelSpec(quantity=chosen.quantity, column=chosen.index, unit=hints.unit) for chosen in read)
    found = (raw_counts_warning(table, spec, chosen.index) for spec, chosen in zip(specs, read, strict=True))
    return [str(table.error(doubt)) for doubt in found if doubt]


def _groups(table: Table, hints: Hints, refused: list[str]) -> tuple[_Group, ...]:
    """Return the columns to read, grouped by clock; reasons for columns without a clock are added to `refused`."""
    indices = _columns(table, hints)
    found: dict[object, list[tuple[ChosenColumn, str]]] = {}
    clocks: dict[object, tuple[ChosenColumn | None, Clock | None]] = {}
    for index in indices:
        try:
            column, time = table.columns[index], _time(table, index, hints)
        except RecordError as error:
            refused.append(str(error))
            continue
        key = (time.index if time else None, column.clock, column.samples, column.start_time)
        clocks[key] = (time, column.clock)
        found.setdefault(key, []).append(_channel_of(table, index, hints))
    # Many columns may lack a clock for the same reason.
    refused[:] = dict.fromkeys(refused)
    return tuple(
        _Group(
            layout=Layout(time=clocks[key][0], channels=tuple(c for c, _ in chosen), clock=clocks[key][1]),
            units=tuple(unit for _, unit in chosen),
        )
        for key, chosen in found.items()
    )


def _columns(table: Table, hints: Hints) -> list[int]:
    if hints.columns:
        asked = [int(name) if name.isdigit() else name for name in hints.columns]
        found = [find_column(table, ChannelSpec(quantity="column", column=name)) for name in asked]
        for index in found:
            if fault := _find_fault(table, index, hints):
                raise table.error(f"{column_label(table.columns, index)}: {fault}")
        return found
    indices = [k for k, column in enumerate(table.columns) if not _find_fault(table, k, hints) and not is_time(column)]
    if table.is_ordered and len(indices) > 1 and indices[0] == 0 and is_row_number(table.columns):
        indices = indices[1:]
    if (
        hints.sample_rate_hz is None
        and len(indices) > 1
        and _is_clock(table, indices[0])
        and _is_increasing(table, indices[0])
    ):
        indices = indices[1:]
    if len(indices) > 1 and (hints.quantity or hints.unit):
        names = ", ".join(column_label(table.columns, k) for k in indices[:8])
        raise table.error(f"which column are --quantity and --unit of? name it with --column; there are {names}")
    return indices


def _is_clock(table: Table, index: int) -> bool:
    """Return whether a column must be the time: the first one of an ordered file without another clock."""
    clocked = any(is_time(column) or column.clock for column in table.columns)
    stated = table.columns[index].stated_unit
    may_be_time = not is_row_number(table.columns) and (stated is None or measures(stated, "time"))
    return table.is_ordered and index == 0 and not clocked and may_be_time


def _time(table: Table, index: int, hints: Hints) -> ChosenColumn | None:
    """Return the time column that belongs to a column, or None if its clock is known otherwise."""
    if table.columns[index].clock:
        return None
    beside = find_time_column(table, index)
    if beside or hints.sample_rate_hz is not None:
        return beside
    if index > 0 and _is_clock(table, 0) and _is_increasing(table, 0):
        return _choose_in_si(table, 0, "time", "time", table.columns[0].stated_unit)
    raise table.error("no time column; give --sample-rate-hz")


def _is_increasing(table: Table, index: int) -> bool:
    """Return whether a column increases from sample to sample, as a clock does."""
    return bool(np.all(np.diff(table.read([index])[0]) > 0.0))


def _channel_of(table: Table, index: int, hints: Hints) -> tuple[ChosenColumn, str]:
    """Return a column as a channel, and the unit of its values."""
    column, label = table.columns[index], column_label(table.columns, index)
    stated = hints.unit or column.stated_unit
    if hints.quantity is not None:
        return _choose_in_si(table, index, hints.quantity, hints.quantity, stated), si_unit(hints.quantity)
    for kind, quantity in QUANTITY_BY_KIND.items() if stated else ():
        if measures(stated or "", quantity):
            return _choose_in_si(table, index, kind, quantity, stated), si_unit(quantity)
    name = column.bare_name or label.replace('"', "")
    return ChosenColumn(index=index, quantity=name, scale=1.0), stated or (COUNTS if column.whole else "")


def _choose_in_si(table: Table, index: int, name: str, quantity: str, unit: str | None) -> ChosenColumn:
    try:
        scale = to_si_factor(unit or si_unit(quantity), quantity)
    except RecordError as error:
        raise table.error(f"{column_label(table.columns, index)}: {error}") from None
    return ChosenColumn(index=index, quantity=name, scale=scale)


def _read(path: Path, table: Table, group: _Group, hints: Hints, refused: list[str]) -> list[Record]:
    """Return the record of a group, or records of its readable channels; other reasons are added to `refused`."""
    try:
        return [_record(path, table, group, hints, refused)]
    except RecordError as error:
        # One bad channel must not lose the others: they are read one by one.
        if len(group.units) > 1:
            return [record for one in group.split() for record in _read(path, table, one, hints, refused)]
        refused.append(str(error))
        return []


def _record(path: Path, table: Table, group: _Group, hints: Hints, refused: list[str]) -> Record:
    samples, odd = _sample_group(table, group, hints)
    if samples.data[0].size < MIN_SAMPLES:
        raise table.error(f"{samples.data[0].size} samples; a record needs {MIN_SAMPLES} at least")
    channels = [_channel(table, group, k, samples) for k in range(len(group.units))]
    limits = {channel.quantity: extremes(channel.data) for channel in channels}
    wild = [channel for channel in channels if max(map(abs, limits[channel.quantity])) > LARGEST_VALUE]
    if wild:
        raise table.error(f'"{wild[0].column}": numbers beyond {LARGEST_VALUE:g} are no measurement')
    # A constant channel is left out with a warning; only a file without any other channel is an error.
    dead = [channel for channel in channels if len(set(limits[channel.quantity])) == 1]
    said = [
        str(
            table.error(
                f'"{c.column}": constant at {limits[c.quantity][0]:.9g} {c.unit}'.rstrip() + ": the channel is dead"
            )
        )
        for c in dead
    ]
    if len(dead) == len(channels):
        raise RecordError(said[0])
    refused.extend(said)
    return Record(
        name=path.stem,
        path=path,
        digest=digest_of(path),
        time_start_s=samples.clock.start_s,
        sample_rate_hz=samples.clock.rate_hz,
        channels=tuple(channel for channel in channels if channel not in dead),
        warnings=odd,
        start_time=table.columns[group.layout.channels[0].index].start_time,
        metadata=table.metadata,
        treatments=samples.treatments,
    )


def _sample_group(table: Table, group: _Group, hints: Hints) -> tuple[Samples, tuple[str, ...]]:
    """Return the samples of a group and warnings; irregular stamps are replaced by the nearest regular clock."""
    first: RecordError | None = None
    for how in (Conditioning(max_gap_s=math.inf), *_fallback_conditionings(table, group, hints)):
        try:
            spec = RecordSpec(name="", path="", sample_rate_hz=hints.sample_rate_hz, conditioning=how)
            samples = sample(table, group.layout, spec)
            return samples, (str(first),) if first else ()
        except RecordError as error:
            first = first or error
    raise first or table.error("no samples")


def _fallback_conditionings(table: Table, group: _Group, hints: Hints) -> Iterator[Conditioning]:
    """Yield increasingly tolerant conditionings: without missing ends, then with irregular time stamps."""
    window_s = _finite_span(table, group, hints)
    if window_s:
        yield Conditioning(max_gap_s=math.inf, window_s=window_s)
    if group.layout.time and hints.sample_rate_hz is None:
        for stamps in (TimeStamps.REGULAR, TimeStamps.RESAMPLE):
            yield Conditioning(max_gap_s=math.inf, window_s=window_s, time_stamps=stamps)


def _finite_span(table: Table, group: _Group, hints: Hints) -> tuple[float, float] | None:
    """Return the record times in s of the first and last sample present in all channels; None if no end is missing."""
    layout = group.layout
    arrays = table.read([column.index for column in layout.selected_columns])
    good = np.flatnonzero(np.all(np.isfinite(arrays[-len(layout.channels) :]), axis=0))
    if not good.size:
        raise table.error(f"{column_label(table.columns, layout.channels[0].index)}: no finite number")
    ends = good[[0, -1]]
    if ends[0] == 0 and ends[1] == arrays[0].size - 1:
        return None
    if layout.time:
        times = time_unit(table, layout.time, RecordSpec(name="", path=""), arrays[0]).seconds(arrays[0][ends])
    else:
        clock = layout.clock or Clock(0.0, hints.sample_rate_hz or 1.0)
        times = clock.start_s + ends / clock.rate_hz
    return float(times[0]), float(times[1])


def _channel(table: Table, group: _Group, number: int, samples: Samples) -> Channel:
    chosen = group.layout.channels[number]
    column = table.columns[chosen.index]
    return Channel(
        quantity=chosen.quantity,
        unit=group.units[number],
        data=samples.data[number],
        role=chosen.role,
        column=column.key or str(chosen.index),
        metadata=column.metadata,
        scale=chosen.scale,
        bridged=samples.bridged.get(number, no_samples()),
    )
