"""Checks for ambiguous numbers in a column: scaling that is not applied, and integers that may be raw counts."""

from __future__ import annotations

from mechid.records.spec import ChannelSpec
from mechid.records.table import Table, column_label
from mechid.units import si_unit


def refuse_unapplied_scaling(table: Table, channel: ChannelSpec, index: int) -> None:
    """Raise an error for a column with an unknown scaling, unless the campaign states its unit and gain.

    Raises
    ------
    RecordError
        The scaling is unknown; the message contains the campaign entry that resolves it.
    """
    # A time column has no gain entry.
    is_time = channel.quantity == "time"
    is_settled = channel.unit is not None and (is_time or channel.gain is not None)
    if is_settled or not table.columns[index].unapplied:
        return
    key, unit = table.columns[index].key, si_unit(channel.quantity)
    how = f'column = "{key}", unit = "{unit}"' if key else f'column = {index}, unit = "{unit}"'
    entry = f'channels = [{{ quantity = "{channel.quantity}", {how}, gain = ... }}]'
    if is_time:
        entry = f"time = {{ {how} }}"
    fault = unapplied_fault(table, index, f"write unit and gain of the numbers as they are stored: {entry}")
    if fault:
        raise table.error(f"{column_label(table.columns, index)}: {fault}")


def unapplied_fault(table: Table, index: int, remedy: str) -> str | None:
    """Return a message about scaling in the file that is not applied to a column, with a remedy, or None."""
    found = table.columns[index].unapplied
    if not found:
        return None
    return f"the file states {found}, but not how to apply it or whether the numbers are scaled already; {remedy}"


def raw_counts_warning(table: Table, channel: ChannelSpec, index: int) -> str | None:
    """Return a warning about integers read as a measured quantity without unit or gain in the campaign, or None."""
    # A unit in the file is no proof of scaled values: many programs store the channel's unit with raw converter counts.
    column = table.columns[index]
    if not column.whole or channel.unit or channel.gain is not None or channel.quantity == "time":
        return None
    label, unit = column_label(table.columns, index), column.stated_unit
    if unit is None:
        read_in = si_unit(channel.quantity)
        return f"{label}: integers without a unit, read in {read_in}; are they raw counts? then give unit and gain"
    return (
        f'{label}: integers, read in "{unit}" as the file says; are they raw counts? then give unit and gain, '
        f'otherwise unit = "{unit}"'
    )
