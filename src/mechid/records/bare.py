"""A file of which nobody has said what it holds: every column that can be a channel, as far as the file tells.

What it is follows from its unit. A column without one keeps its own numbers, and its name.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mechid.errors import RecordError, UsageError, did_you_mean
from mechid.records.column_names import is_row_number, is_time
from mechid.records.columns import ChosenColumn, Layout, find_column, find_time_column
from mechid.records.conditioning import Samples
from mechid.records.doubts import raw_counts_warning, unapplied_fault
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
"""What a unit tells, and a quantity of that unit."""
LARGEST_VALUE = 1e100
MAX_LISTED_COLUMNS = 8
OVERRIDE_REMEDY = "give --column and --unit, that of the numbers as they are stored; in a campaign, unit and gain"
COUNTS = "counts"
"""Unit of whole numbers without one."""


@dataclass(frozen=True, kw_only=True)
class Hints:
    """What a user says of the columns of bare files; all of it may be left out.

    Parameters
    ----------
    sample_rate_hz : float or None
        Of a file without a clock.
    columns : tuple of str
        Those to look at, by name or by index from 0; empty means all.
    quantity, unit : str or None
        What they are, one of `mechid.units.SI_UNIT`, and the unit of the file's numbers.

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
    """Columns that are sampled together, with the units of what is read of them."""

    layout: Layout
    units: tuple[str, ...]

    def split(self) -> tuple[_Group, ...]:
        """Return every channel by itself."""
        pairs = zip(self.layout.channels, self.units, strict=True)
        return tuple(_Group(layout=replace(self.layout, channels=(c,)), units=(unit,)) for c, unit in pairs)


def read_bare(path: Path, hints: Hints | None = None) -> tuple[Record, ...]:
    """Read all channels of a file: one record for those that are sampled together.

    Missing samples are bridged, and irregular time stamps put on the nearest regular clock; the treatments tell it. A
    column that cannot be a channel is named in the warnings of the first record.

    Parameters
    ----------
    path : Path
    hints : Hints or None

    Raises
    ------
    RecordError
        The file is missing, is no record, or holds no channel that can be read; one line.
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
    """Return one line that names the columns that are not looked at; none where all are, or some are asked for."""
    named = [] if hints.columns else [k for k in range(len(table.columns)) if _find_fault(table, k, hints)]
    said = [f"{column_label(table.columns, k)}: {_find_fault(table, k, hints)}" for k in named[:MAX_LISTED_COLUMNS]]
    more = [f"{len(named) - MAX_LISTED_COLUMNS} more"] if len(named) > MAX_LISTED_COLUMNS else []
    return [str(table.error("; ".join([*said, *more])))] if named else []


def _find_fault(table: Table, index: int, hints: Hints) -> str | None:
    """Return why a column is not looked at."""
    column = table.columns[index]
    if column.fault or hints.unit is not None:
        return column.fault
    return unapplied_fault(table, index, OVERRIDE_REMEDY)


def _raw_count_warnings(table: Table, groups: Sequence[_Group], hints: Hints) -> list[str]:
    """Return the warnings of integers that are read in a unit of the file and may be raw counts."""
    read = [chosen for group in groups for chosen in group.layout.channels if table.columns[chosen.index].stated_unit]
    specs = (ChannelSpec(quantity=chosen.quantity, column=chosen.index, unit=hints.unit) for chosen in read)
    found = (raw_counts_warning(table, spec, chosen.index) for spec, chosen in zip(specs, read, strict=True))
    return [str(table.error(doubt)) for doubt in found if doubt]


def _groups(table: Table, hints: Hints, refused: list[str]) -> tuple[_Group, ...]:
    """Return the columns to look at, those of one clock together; why others have none is added to `refused`."""
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
    refused[:] = dict.fromkeys(refused)  # many columns may lack a clock for one reason
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
    """Tell whether a column has to be the time: the first of an ordered file that has no other clock."""
    clocked = any(is_time(column) or column.clock for column in table.columns)
    stated = table.columns[index].stated_unit
    may_be_time = not is_row_number(table.columns) and (stated is None or measures(stated, "time"))
    return table.is_ordered and index == 0 and not clocked and may_be_time


def _time(table: Table, index: int, hints: Hints) -> ChosenColumn | None:
    """Return the time column of a column, None where the clock is known without."""
    if table.columns[index].clock:
        return None
    beside = find_time_column(table, index)
    if beside or hints.sample_rate_hz is not None:
        return beside
    if index > 0 and _is_clock(table, 0) and _is_increasing(table, 0):
        return _choose_in_si(table, 0, "time", "time", table.columns[0].stated_unit)
    raise table.error("no time column; give --sample-rate-hz")


def _is_increasing(table: Table, index: int) -> bool:
    """Tell whether a column grows from sample to sample, as a clock does."""
    return bool(np.all(np.diff(table.read([index])[0]) > 0.0))


def _channel_of(table: Table, index: int, hints: Hints) -> tuple[ChosenColumn, str]:
    """Return a column as a channel, and the unit of what is read of it."""
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
    """Return the record of a group, or of those of its channels that can be read; why the others cannot is added."""
    try:
        return [_record(path, table, group, hints, refused)]
    except RecordError as error:
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
    """Return the samples of a group, its stamps as they are, else on the nearest clock; and what is odd about them."""
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
    """Yield ways of conditioning that put up with more: without missing ends, then with stamps that are not regular."""
    window_s = _finite_span(table, group, hints)
    if window_s:
        yield Conditioning(max_gap_s=math.inf, window_s=window_s)
    if group.layout.time and hints.sample_rate_hz is None:
        for stamps in (TimeStamps.REGULAR, TimeStamps.RESAMPLE):
            yield Conditioning(max_gap_s=math.inf, window_s=window_s, time_stamps=stamps)


def _finite_span(table: Table, group: _Group, hints: Hints) -> tuple[float, float] | None:
    """Return the record time in s from the first to the last sample that all channels have; None where it is all."""
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
