"""Channels of a campaign with their statistics, and the content of a bare data file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import count
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.ink.console import print_lines, say
from mechid.ink.digits import digits, plain
from mechid.ink.text_table import Column as Shown
from mechid.ink.text_table import print_tables
from mechid.records import Channel, Column, Record, Sampling, open_table, samplings
from mechid.signal.moments import extremes, mean, root_mean_square

CHANNEL = Shown("channel", "quantity", words=True)
ORIGIN = (Shown("column", "column", words=True), Shown("unit", "unit", words=True))
CLOCK = (
    Shown("samples", "samples"),
    Shown("rate Hz", "sample_rate_hz"),
    Shown("from s", "start_s"),
    Shown("lasts s", "duration_s"),
)
STATISTICS = (
    Shown("min", "min"),
    Shown("max", "max"),
    Shown("mean", "mean"),
    Shown("RMS", "rms"),
    Shown("noise", "noise_sigma"),
)
CHANNEL_LAYOUTS = (
    ((CHANNEL, *ORIGIN, *CLOCK, *STATISTICS),),
    ((CHANNEL, *ORIGIN, *CLOCK), (CHANNEL, *STATISTICS)),
)
FILE_LAYOUTS = (
    (
        (
            Shown("index", "index"),
            Shown("column", "column", words=True),
            Shown("unit", "unit", words=True),
            Shown("samples", "samples"),
            Shown("rate Hz", "sample_rate_hz"),
            Shown("from s", "start_s"),
            Shown("", "clock", words=True),
        ),
    ),
)
MOST_FACTS = 40
"""So many entries of a file's metadata are shown."""


def channel_rows(records: Iterable[Record | None]) -> list[dict[str, Any]]:
    """Return a row for each channel of all records that were read, with its statistics in SI."""
    return [_channel_row(record, channel) for record in records if record for channel in record.channels]


def print_channels(console: Console, rows: Sequence[Mapping[str, Any]]) -> None:
    """Print the rows of all records' channels, each under its record."""
    print_tables(console, CHANNEL_LAYOUTS, rows)


def file_data(path: Path) -> dict[str, Any]:
    """Return what a data file holds: its columns with unit, length and sampling, and what it says of itself.

    Raises
    ------
    RecordError
        The file is missing, of an unknown format, or damaged.
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


def print_file(data: Mapping[str, Any], console: Console) -> None:
    """Print what `file_data` made."""
    say(console, data["file"], "bold")
    if data["columns"]:
        print_tables(console, FILE_LAYOUTS, data["columns"])
    others = (f"{row['index']} {row['column']}: {row['fault']}" for row in data["no_channels"])
    print_lines(console, "no channel", others)
    shown = list(data["metadata"].items())[:MOST_FACTS]
    print_lines(console, "says", (f"{key} = {value}" for key, value in shown), "dim")
    if len(data["metadata"]) > len(shown):
        say(console, f"and {len(data['metadata']) - len(shown)} more entries")
    print_lines(console, "warning", data["warnings"], "yellow")


def _channel_row(record: Record, channel: Channel) -> dict[str, Any]:
    values = channel.data
    low, high = extremes(values)
    numbers = {
        "samples": record.samples,
        "sample_rate_hz": record.sample_rate_hz,
        "start_s": record.time_start_s,
        "duration_s": record.duration_s,
        "min": low,
        "max": high,
        "mean": mean(values),
        "rms": root_mean_square(values),
        "noise_sigma": record.noise_floor(channel.quantity),
    }
    exact = {key: plain(numbers[key], 9) for key in ("samples", "sample_rate_hz", "start_s", "duration_s")}
    measured = {key: digits(numbers[key], 4) for key in ("min", "max", "mean", "rms", "noise_sigma")}
    row = {"table": record.name, "quantity": channel.quantity, "column": channel.column, "unit": channel.unit}
    return {**row, **numbers, "text": {**exact, **measured}}


def _column_row(index: int, column: Column, sampling: Sampling) -> dict[str, Any]:
    regular = sampling.clock is not None
    numbers = {
        "samples": sampling.samples,
        "sample_rate_hz": sampling.clock.rate_hz if sampling.clock else sampling.irregular_hz,
        "start_s": sampling.clock.start_s if sampling.clock else None,
    }
    shown = {"samples": 9, "sample_rate_hz": 9 if regular else 4, "start_s": 9}
    texts = {key: "" if value is None else plain(value, shown[key]) for key, value in numbers.items()}
    words = {
        "column": column.key,
        "unit": column.stated_unit or "",
        "clock": "irregular" if sampling.irregular_hz else "",
        "fault": column.fault or "",
    }
    return {"index": index, **words, **numbers, "text": texts}
