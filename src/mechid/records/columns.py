"""Which column of a file is the clock, which are the channels, and what makes them SI."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mechid.errors import RecordError, did_you_mean
from mechid.records.spec import ChannelSpec, RecordSpec, Role
from mechid.records.table import Table, column_label
from mechid.units import si_unit, split_header, to_si_factor


@dataclass(frozen=True, kw_only=True)
class ChosenColumn:
    """A column to be read, and what its numbers are multiplied by to be `quantity` in SI."""

    index: int
    quantity: str
    scale: float
    role: Role = Role.OUTPUT
    warning: str | None = None


@dataclass(frozen=True, kw_only=True)
class Layout:
    """The columns to be read; `time` is None where the file is not asked for its clock."""

    time: ChosenColumn | None
    channels: tuple[ChosenColumn, ...]

    @property
    def chosen(self) -> tuple[ChosenColumn, ...]:
        """All columns, the time first."""
        return self.channels if self.time is None else (self.time, *self.channels)


def choose_columns(table: Table, spec: RecordSpec) -> Layout:
    """Find the columns that `spec` asks for in the head of `table`.

    Raises
    ------
    RecordError
        A column does not exist, is not unique, has the wrong unit, or the clock is missing.
    """
    asked = spec.channels or (_default_torque(table, spec),)
    indices = [_find(table, channel) for channel in asked]
    _refuse_twice(table, asked, indices)
    channels = tuple(map(_choose, [table] * len(asked), asked, indices))
    return Layout(time=_choose_time(table, spec, indices), channels=channels)


def _default_torque(table: Table, spec: RecordSpec) -> ChannelSpec:
    """Torque is the second column, after the time, or the first where the rate is given."""
    if spec.sample_rate_hz is None:
        if len(table.columns) < 2:
            raise table.error("one column only; add a time column before it, or give sample_rate_hz")
        return ChannelSpec(quantity="torque", column=1)
    if _is_time(table.columns[0]):
        raise table.error(
            f"{column_label(table.columns, 0)}: with sample_rate_hz and no channels the first column is "
            "the torque; leave sample_rate_hz out, or name the channels"
        )
    return ChannelSpec(quantity="torque", column=0)


def _find(table: Table, channel: ChannelSpec) -> int:
    """Return the index of the channel's column: an exact header wins over a name without its unit."""
    columns, wanted = table.columns, channel.column
    if isinstance(wanted, int):
        if not 0 <= wanted < len(columns):
            raise table.error(f"{channel.quantity}: no column {wanted}; they go from 0 to {len(columns) - 1}")
        return wanted
    names = [split_header(column)[0] for column in columns]
    found = [i for i, column in enumerate(columns) if column == wanted]
    found = found or [i for i, name in enumerate(names) if name == wanted]
    if len(found) > 1:
        raise table.error(f'{channel.quantity}: {len(found)} columns "{wanted}"; give the index from 0')
    if not found:
        raise table.error(f'{channel.quantity}: unknown column "{wanted}"{_known(wanted, columns, names)}')
    return found[0]


def _known(wanted: str, columns: Sequence[str], names: Sequence[str]) -> str:
    if not any(columns):
        return f"; the file has no header, give the index, 0 to {len(columns) - 1}"
    listed = ", ".join(f'"{column}"' for column in columns[:8])
    return did_you_mean(wanted, [*names, *columns]) or f"; the file has {listed}"


def _refuse_twice(table: Table, asked: Sequence[ChannelSpec], indices: Sequence[int]) -> None:
    quantities = [channel.quantity for channel in asked]
    for position, (quantity, index) in enumerate(zip(quantities, indices, strict=True)):
        if quantity in quantities[:position]:
            raise table.error(f"{quantity}: two channels of one record; keep one of them")
        if index in indices[:position]:
            label = column_label(table.columns, index)
            raise table.error(f"{quantity}: {label} is already {quantities[indices.index(index)]}")


def _choose(table: Table, channel: ChannelSpec, index: int) -> ChosenColumn:
    factor, warning = _factor(table, channel, index)
    return ChosenColumn(
        index=index,
        quantity=channel.quantity,
        scale=factor * channel.gain,
        role=channel.role,
        warning=warning,
    )


def _choose_time(table: Table, spec: RecordSpec, taken: Sequence[int]) -> ChosenColumn | None:
    """Return the time column: called so by its header, else the first; None where it is not needed."""
    if spec.sample_rate_hz is not None and not spec.channels:
        return None
    free = [index for index in range(len(table.columns)) if index not in taken]
    named = [index for index in free if _is_time(table.columns[index])]
    if spec.sample_rate_hz is not None and not named:
        return None
    if not named and 0 in taken:
        raise table.error("no time column; give sample_rate_hz")
    index = (named or [0])[0]
    return _choose(table, ChannelSpec(quantity="time", column=index), index)


def _is_time(column: str) -> bool:
    name = split_header(column)[0].lower()
    return name == "t" or name.startswith("time")


def _factor(table: Table, channel: ChannelSpec, index: int) -> tuple[float, str | None]:
    """Return the factor to SI, from the campaign's unit and the header's, and a warning if they differ.

    A header whose unit measures the same quantity must agree. One that measures something else
    gives way to the campaign's unit: in brackets (volts of a transducer, say) with a warning; at
    the end of a name it may not be a unit at all, as in ``u_A``.
    """
    quantity, label = channel.quantity, column_label(table.columns, index)
    in_header = split_header(table.columns[index])[1]
    try:
        if channel.unit is None:
            return to_si_factor(in_header or si_unit(quantity), quantity), None
        factor = to_si_factor(channel.unit, quantity)
    except RecordError as error:
        remedy = "; if that is no unit, name the right one in channels" if in_header and not channel.unit else ""
        raise table.error(f"{label}: {error}{remedy}") from None
    if in_header is None or _factor_or_none(in_header, quantity) == factor:
        return factor, None
    if _factor_or_none(in_header, quantity) is not None:
        raise table.error(f'{label}: its unit contradicts unit = "{channel.unit}" of the campaign; correct one')
    if table.columns[index].endswith(("]", ")")):
        return factor, f'{label}: taken in "{channel.unit}", as the campaign says, not in "{in_header}"'
    return factor, None


def _factor_or_none(unit: str, quantity: str) -> float | None:
    try:
        return to_si_factor(unit, quantity)
    except RecordError:
        return None
