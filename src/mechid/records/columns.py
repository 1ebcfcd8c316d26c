"""Selection of a file's time column and channel columns, and of their factors to SI units."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from mechid.errors import RecordError, did_you_mean
from mechid.records.ambiguous_numbers import raw_counts_warning, refuse_unapplied_scaling
from mechid.records.column_names import is_row_number, is_time, is_torque
from mechid.records.spec import VOLTAGE, ChannelSpec, RecordSpec, Role
from mechid.records.table import Clock, Column, Table, column_label
from mechid.units import si_unit, split_header, to_si_factor, unit_within


@dataclass(frozen=True, kw_only=True)
class ChosenColumn:
    """Column to be read as a quantity, with the factor `scale` to SI units."""

    index: int
    quantity: str
    scale: float
    role: Role = Role.OUTPUT
    warning: str | None = None
    in_volts: bool = False


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Columns to be read; `time` is None if the clock is known otherwise, `clock` is None if it is not known."""

    time: ChosenColumn | None
    channels: tuple[ChosenColumn, ...]
    clock: Clock | None = None

    @property
    def selected_columns(self) -> tuple[ChosenColumn, ...]:
        """All selected columns, the time first."""
        return self.channels if self.time is None else (self.time, *self.channels)


def choose_columns(table: Table, spec: RecordSpec) -> Layout:
    """Find the columns that `spec` declares in the header of `table`.

    Raises
    ------
    RecordError
        A column does not exist, is not unique, cannot be a channel, has the wrong unit, differs in length from the
        others, or the clock is missing.
    """
    asked = spec.channels or (_default_torque(table, spec),)
    indices = [find_column(table, channel) for channel in asked]
    _refuse_duplicates(table, asked, indices)
    choose = _choose if spec.channels else _choose_by_position
    channels = tuple(map(choose, [table] * len(asked), asked, indices))
    clock = None if spec.time else _common_clock(table, indices)
    time = None if clock else _choose_time(table, spec, indices)
    layout = Layout(time=time, channels=channels, clock=clock)
    _refuse_other_length(table, [column.index for column in layout.selected_columns])
    return layout


def _default_torque(table: Table, spec: RecordSpec) -> ChannelSpec:
    """Return the default torque column: the second one, after the time, or the first one if the rate is given.

    Row numbers before a time column are skipped. If columns have no order, the torque is the column of that name, or
    the only one.
    """
    if not table.is_ordered:
        columns = table.columns
        usable = [index for index, column in enumerate(columns) if column.fault is None]
        called = [index for index, column in enumerate(columns) if column.bare_name.lower() == "torque"]
        called = [index for index in called if index in usable] or called
        # A faulty column is selected so that its fault is reported.
        chosen = called or usable or [*range(len(columns))]
        if len(chosen) == 1:
            return ChannelSpec(quantity="torque", column=chosen[0])
        raise table.error(
            f"torque: which column is it? name it in channels; the file has {_list_columns(table.columns)}"
        )
    if spec.sample_rate_hz is None:
        if len(table.columns) < 2:
            raise table.error("one column only; add a time column before it, or give sample_rate_hz")
        return ChannelSpec(quantity="torque", column=2 if _has_row_numbers_before_time(table) else 1)
    if len(table.columns) > 1 and is_row_number(table.columns):
        raise table.error(
            f"{_describe_row_numbers(table)}, not the torque; name the torque's column, as "
            'channels = [{ quantity = "torque", column = ... }]'
        )
    if is_time(table.columns[0]):
        raise table.error(
            f"{column_label(table.columns, 0)}: with sample_rate_hz and no channels the first column is "
            "the torque; leave sample_rate_hz out, or name the channels"
        )
    return ChannelSpec(quantity="torque", column=0)


def _describe_row_numbers(table: Table) -> str:
    why = "a count of samples by its name" if table.columns[0].key else "without a name beside others: a row number"
    return f"{column_label(table.columns, 0)}: {why}"


def _has_row_numbers_before_time(table: Table) -> bool:
    """Return whether time and torque follow row numbers, as in a data frame written with its index."""
    return len(table.columns) > 2 and is_row_number(table.columns) and is_time(table.columns[1])


def _choose_by_position(table: Table, torque: ChannelSpec, index: int) -> ChosenColumn:
    """Select the torque by position; a warning or the error names another column that has the name of a torque."""
    name = _torque_by_name(table, index)
    if name is None:
        return _choose(table, torque, index)
    taken = column_label(table.columns, index)
    remedy = f'channels = [{{ quantity = "torque", column = "{name}" }}]'
    doubt = f"{taken} is taken for the torque by its place; is it not {name}? write {remedy}"
    try:
        return replace(_choose(table, torque, index), warning=doubt)
    except RecordError as error:
        raise RecordError(f"{error}; {doubt}") from None


def other_torque_column(table: Table) -> str | None:
    """Return the name of a column named like a torque, if the column selected by position is not; otherwise None.

    Raises
    ------
    RecordError
        No column can be selected by position.
    """
    return _torque_by_name(table, find_column(table, _default_torque(table, RecordSpec(name="", path=""))))


def _torque_by_name(table: Table, index: int) -> str | None:
    called = [number for number, column in enumerate(table.columns) if is_torque(column)]
    return table.columns[called[0]].bare_name if called and index not in called else None


def find_column(table: Table, channel: ChannelSpec) -> int:
    """Return the index of the channel's column.

    The column is searched by index; by path; by name, with its unit before without; by the end of a path.

    Raises
    ------
    RecordError
        There is no such column, or more than one, or it cannot be a channel.
    """
    columns, wanted = table.columns, channel.column
    if isinstance(wanted, int):
        if not 0 <= wanted < len(columns):
            raise table.error(f"{channel.quantity}: no column {wanted}; they go from 0 to {len(columns) - 1}")
        found = [wanted]
    else:
        found = _match_columns(columns, wanted.removeprefix("/"))
    if len(found) > 1:
        remedy = _disambiguation([columns[index] for index in found])
        raise table.error(f'{channel.quantity}: {len(found)} columns "{wanted}"; {remedy}')
    if not found:
        raise table.error(f'{channel.quantity}: unknown column "{wanted}"{_suggest_columns(str(wanted), columns)}')
    fault = columns[found[0]].fault
    if fault:
        raise table.error(f"{channel.quantity}: {column_label(columns, found[0])}: {fault}")
    return found[0]


def _match_columns(columns: Sequence[Column], wanted: str) -> list[int]:
    """Return the columns that match a text by the first rule with any match."""
    # From the most to the least specific rule: an exact name must not be hidden by the end of another path.
    rules: tuple[Callable[[Column], bool], ...] = (
        lambda column: column.key == wanted,
        lambda column: column.name == wanted,
        lambda column: column.bare_name == wanted,
        lambda column: column.key.endswith(f"/{wanted}"),
    )
    matches = ([index for index, column in enumerate(columns) if rule(column)] for rule in rules)
    return next(filter(None, matches), [])


def _disambiguation(columns: Sequence[Column]) -> str:
    """Return the remedy for several columns of the same name."""
    keys = [column.key for column in columns]
    if len(set(keys)) < len(keys):
        return "give the index from 0"
    return "give the path: " + " or ".join(f'"{key}"' for key in keys[:8])


def _suggest_columns(wanted: str, columns: Sequence[Column]) -> str:
    if not any(column.key for column in columns):
        return f"; the file has no header, give the index, 0 to {len(columns) - 1}"
    names = [text for column in columns for text in (column.bare_name, column.name, column.key)]
    return did_you_mean(wanted, names) or f"; the file has {_list_columns(columns)}"


def _list_columns(columns: Sequence[Column]) -> str:
    listed = ", ".join(f'"{column.key}"' for column in columns[:8])
    return f"{listed} and {len(columns) - 8} more" if len(columns) > 8 else listed


def _refuse_duplicates(table: Table, asked: Sequence[ChannelSpec], indices: Sequence[int]) -> None:
    quantities = [channel.quantity for channel in asked]
    for position, (quantity, index) in enumerate(zip(quantities, indices, strict=True)):
        if quantity in quantities[:position]:
            raise table.error(f"{quantity}: two channels of one record; keep one of them")
        if index in indices[:position]:
            label = column_label(table.columns, index)
            raise table.error(f"{quantity}: {label} is already {quantities[indices.index(index)]}")


def _refuse_other_length(table: Table, indices: Sequence[int]) -> None:
    first = indices[0]
    for index in indices[1:]:
        if table.columns[index].samples != table.columns[first].samples:
            lengths = [f"{column_label(table.columns, k)} has {table.columns[k].samples}" for k in (first, index)]
            raise table.error(f"{lengths[0]} samples, {lengths[1]}; channels of one record are sampled together")


def _common_clock(table: Table, indices: Sequence[int]) -> Clock | None:
    """Return the clock that the file states for the channels; raise RecordError if they differ."""
    first, *others = (table.columns[index] for index in indices)
    for index, column in zip(indices[1:], others, strict=True):
        if column.clock == first.clock and column.start_time == first.start_time:
            continue
        labels = f"{column_label(table.columns, indices[0])} and {column_label(table.columns, index)}"
        clocks = f"{_describe_clock(first)}; {_describe_clock(column)}"
        raise table.error(f"{labels} have not the same clock ({clocks}); make two records of it")
    return first.clock


def _describe_clock(column: Column) -> str:
    if column.clock is None:
        return "none"
    start = f" on {column.start_time}" if column.start_time else ""
    return f"{column.clock.rate_hz:.9g} Hz from {column.clock.start_s:.9g} s{start}"


def _choose(table: Table, channel: ChannelSpec, index: int) -> ChosenColumn:
    _refuse_without_unit(table, channel, index)
    refuse_unapplied_scaling(table, channel, index)
    factor, warning = _factor(table, replace(channel, quantity=VOLTAGE) if channel.in_volts else channel, index)
    return ChosenColumn(
        index=index,
        quantity=channel.quantity,
        scale=factor * (1.0 if channel.gain is None else channel.gain),
        role=channel.role,
        warning=warning or raw_counts_warning(table, channel, index),
        in_volts=channel.in_volts,
    )


def _refuse_without_unit(table: Table, channel: ChannelSpec, index: int) -> None:
    """Raise RecordError for a side component without a unit: nothing else in the record would reveal a wrong one."""
    if channel.role is Role.SIDE and channel.unit is None and table.columns[index].stated_unit is None:
        label, unit = column_label(table.columns, index), si_unit(channel.quantity)
        raise table.error(f'{channel.quantity}: {label} states no unit; write unit = "{unit}" or its own in channels')


def _choose_time(table: Table, spec: RecordSpec, taken: Sequence[int]) -> ChosenColumn | None:
    """Return the time column: declared, named, or the first one of an ordered file; None if it is not needed."""
    if spec.time is not None:
        return _choose(table, spec.time, find_column(table, spec.time))
    if spec.sample_rate_hz is not None and not spec.channels and table.is_ordered:
        return None
    named = _time_candidates(table, taken)
    if spec.sample_rate_hz is not None and not named:
        return None
    if not named and (0 in taken or not table.is_ordered):
        raise table.error("no time column; give sample_rate_hz")
    if len(named) > 1 and not table.is_ordered:
        names = [table.columns[index] for index in named]
        raise table.error(
            f"{len(named)} columns may be the time; name it, as time = {{ column = ... }}: {_list_columns(names)}"
        )
    index = (named or [0])[0]
    if index == 0 and is_row_number(table.columns):
        raise table.error(
            f"{_describe_row_numbers(table)}, not the time in seconds; give sample_rate_hz, and the torque's column in "
            "channels"
        )
    return _choose(table, ChannelSpec(quantity="time", column=index), index)


def find_time_column(table: Table, index: int) -> ChosenColumn | None:
    """Return the time column that belongs to a column, or None if there is none or several."""
    named = [index] if is_time(table.columns[index]) else _time_candidates(table, [index])
    if len(named) != 1 and not (named and table.is_ordered):
        return None
    return _choose(table, ChannelSpec(quantity="time", column=named[0]), named[0])


def _time_candidates(table: Table, taken: Sequence[int]) -> list[int]:
    """Return the columns that may be the time by their names, those in the channels' folder before others."""
    first = table.columns[taken[0]]
    free = [index for index in range(len(table.columns)) if index not in taken]
    named = [index for index in free if is_time(table.columns[index]) and table.columns[index].fault is None]
    fitting = [index for index in named if table.columns[index].samples == first.samples]
    # In a grouped file the time is in the channel's own group, or in the group above.
    folders = [first.key.rpartition("/")[0], first.key.rpartition("/")[0].rpartition("/")[0]]
    for folder in folders:
        beside = [index for index in fitting if table.columns[index].key.rpartition("/")[0] == folder]
        if beside:
            return beside
    return fitting


def _factor(table: Table, channel: ChannelSpec, index: int) -> tuple[float, str | None]:
    """Return the factor to SI units from the units of campaign and file, and a warning if these differ.

    If the file's unit measures the same quantity, both must agree. Otherwise the campaign's unit is used, with a
    warning unless the file's is a suffix of the name, as in ``u_A``.
    """
    column, quantity, label = table.columns[index], channel.quantity, column_label(table.columns, index)
    in_file, in_name = column.stated_unit, split_header(column.name)[1]
    word = None if channel.unit or in_file else unit_within(column.name, quantity)
    if word:
        raise table.error(
            f'{label}: "{word}" in its name may be its unit, and stands where none is read; write its unit in '
            f'the campaign file (unit = "{si_unit(quantity)}" if that is it), or in brackets at the end of its name'
        )
    doubt = None if channel.unit or in_file else column.unit_doubts.get(quantity)
    if doubt:
        raise table.error(
            f"{label}: states no unit, but {doubt}; write its unit in brackets at the end of its name, or in the "
            f'campaign file (unit = "{si_unit(quantity)}" if that is it)'
        )
    # Two statements in the file must agree with each other before they are compared with the campaign.
    twice = [_factor_or_none(unit, quantity) for unit in (in_file, in_name) if unit]
    if None not in twice and len(set(twice)) > 1:
        raise table.error(f'{label}: the file states two units, "{in_file}" and "{in_name}"; correct it')
    try:
        if channel.unit is None:
            return to_si_factor(in_file or si_unit(quantity), quantity), None
        factor = to_si_factor(channel.unit, quantity)
    except RecordError as error:
        remedy = "; if that is no unit, name the right one in channels" if in_file and not channel.unit else ""
        raise table.error(f"{label}: {error}{remedy}") from None
    if in_file is None or _factor_or_none(in_file, quantity) == factor:
        return factor, None
    if _factor_or_none(in_file, quantity) is not None:
        raise table.error(f'{label}: its unit contradicts unit = "{channel.unit}" of the campaign; correct one')
    if column.unit or column.name.endswith(("]", ")")):
        return factor, f'{label}: read in "{channel.unit}", as the campaign says, not in "{in_file}"'
    return factor, None


def _factor_or_none(unit: str, quantity: str) -> float | None:
    try:
        return to_si_factor(unit, quantity)
    except RecordError:
        return None
