"""Names of files for the channels of a record."""

from __future__ import annotations

import re

from mechid.records.record import Record

_UNSAFE_CHARACTERS = re.compile(r"[^A-Za-z0-9_-]+")


def channel_keys(record: Record) -> list[str]:
    """Return the base name of each channel's files: the record's name, plus the column if there are several."""
    if len(record.channels) == 1:
        return [record.name]
    columns = [_UNSAFE_CHARACTERS.sub("_", one.column).strip("_") or str(k) for k, one in enumerate(record.channels)]
    return [f"{record.name}.{c if columns.count(c) == 1 else f'{c}_{k}'}" for k, c in enumerate(columns)]
