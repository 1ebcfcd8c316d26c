"""Listing of a data file: its columns and its metadata."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import count
from pathlib import Path
from typing import Any

from mechid.ink.digits import plain
from mechid.ink.document import Document, Lines, Rows, Words
from mechid.ink.table import Table
from mechid.ink.text_table import Column as Shown
from mechid.records import Column, Sampling, open_table, samplings

COLUMNS = (
    Shown("index", "index"),
    Shown("column", "column", words=True),
    Shown("unit", "unit", words=True),
    Shown("samples", "samples"),
    Shown("rate Hz", "sample_rate_hz"),
    Shown("from s", "start_s"),
    Shown("", "clock", words=True),
)
# A longer list would hide the columns.
MOST_FACTS = 40
"""Most shown entries of a file's metadata."""


def file_numbers(path: Path) -> dict[str, Any]:
    """Read the columns of a data file, with unit, length and sampling, and its metadata.

    Raises
    ------
    RecordError
        The file is missing, damaged, or of an unknown format.
    """
    table = open_table(path, path.name)
    sampled = samplings(table)
    faults = dict.fromkeys(one.fault for one in sampled if one.fault)
    rows = [_column_row(*one) for one in zip(count(), table.columns, sampled)]
    scaled = [column for column in table.columns if column.unapplied]
    unapplied = [str(table.error(f'column "{column.key}": {column.unapplied} is not applied')) for column in scaled]
    return {
        "file": str(path),
        "columns": [row for row in rows if not row["fault"]],
        "no_channels": [row for row in rows if row["fault"]],
        "metadata": dict(table.metadata),
        "warnings": [*table.warnings, *unapplied, *faults],
    }


def file_document(data: Mapping[str, Any]) -> Document:
    """Make the document from the result of `file_numbers`."""
    facts = list(data["metadata"].items())
    return Document(
        title=data["file"],
        command="mechid check",
        parts=(
            Words(data["file"], "strong"),
            Rows(Table(COLUMNS, data["columns"])),
            Lines([f"{row['index']} {row['column']}: {row['fault']}" for row in data["no_channels"]], "no channel"),
            Lines([f"{key} = {value}" for key, value in facts[:MOST_FACTS]], "says", style="dim"),
            Words(f"and {len(facts) - MOST_FACTS} more entries" if len(facts) > MOST_FACTS else ""),
            Lines(data["warnings"], "warning", style="yellow"),
        ),
    )


def _column_row(index: int, column: Column, sampling: Sampling) -> dict[str, Any]:
    regular = sampling.clock is not None
    numbers = {
        "samples": sampling.samples,
        "sample_rate_hz": sampling.clock.rate_hz if sampling.clock else sampling.irregular_hz,
        "start_s": sampling.clock.start_s if sampling.clock else None,
    }
    # An irregular clock has no exact rate, so that fewer digits are shown.
    shown = {"samples": 9, "sample_rate_hz": 9 if regular else 4, "start_s": 9}
    texts = {key: "" if value is None else plain(value, shown[key]) for key, value in numbers.items()}
    words = {
        "column": column.key,
        "unit": column.stated_unit or "",
        "clock": "irregular" if sampling.irregular_hz else "",
        "fault": column.fault or "",
    }
    return {"index": index, **words, **numbers, "text": texts}
