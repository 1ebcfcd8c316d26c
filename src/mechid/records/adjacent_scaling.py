"""Scaling stated next to an array, in the fields of its struct or in the attributes of its group."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace

from mechid.records.column_names import is_time
from mechid.records.scaling import CF, NAMES, is_scaling_name, plain_name, unapplied_scaling
from mechid.records.table import Column, Metadata


def add_adjacent_scaling(columns: Iterable[Column], metadata: Metadata) -> tuple[Column, ...]:
    """Return columns with the unapplied scaling that the file's metadata state for them.

    ``torque_gain`` next to ``torque`` belongs to that column, and ``gain`` belongs to the only channel of a struct or
    group. At the top level of a file, where ``gain`` may be any variable, it counts for integers only.
    """
    columns = tuple(columns)
    stated = {key: _split(key) for key in metadata if key.endswith(CF) or plain_name(key).endswith(NAMES)}
    if not stated:
        return columns
    channels = [_split(column.key)[0] for column in columns if column.fault is None and not is_time(column)]
    return tuple(
        _with_unapplied(column, {name: metadata[key] for key, name in _scaling_entries(column, stated, channels)})
        for column in columns
    )


def _scaling_entries(
    column: Column, stated: dict[str, tuple[str, str]], channels: list[str]
) -> Iterator[tuple[str, str]]:
    """Yield key and attribute name of each entry that scales a column."""
    folder, own = _split(column.key)[0], column.bare_name.rpartition("/")[2]
    is_only = channels.count(folder) == 1 and not is_time(column) and (bool(folder) or column.whole)
    for key, (place, name) in stated.items():
        extended = re.fullmatch(rf"{re.escape(own)}[_ .-]+(.+)", name, re.IGNORECASE) if own else None
        if place == folder and extended and is_scaling_name(extended[1]):
            yield key, extended[1]
        elif is_only and is_scaling_name(name) and place in (folder, column.key):
            yield key, name


def _with_unapplied(column: Column, beside: Metadata) -> Column:
    has_unit = column.stated_unit is not None
    found = unapplied_scaling(beside, has_unit=has_unit, is_whole=column.whole, is_beside=True)
    return replace(column, unapplied=", ".join(filter(None, (column.unapplied, found)))) if found else column


def _split(key: str) -> tuple[str, str]:
    folder, _, name = key.rpartition("/")
    return folder, name
