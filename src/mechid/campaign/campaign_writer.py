"""Writer of a campaign made in code, as files that `load_campaign` reads back."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mechid.campaign.campaign import Campaign
from mechid.campaign.campaign_file import FILE_NAME
from mechid.campaign.mechanism_text import mechanism_text
from mechid.campaign.templates import MECHANISM_NAME
from mechid.campaign.toml_file import toml_number, toml_text
from mechid.command import Command
from mechid.errors import UsageError
from mechid.records.in_memory import TIME, SampleColumns
from mechid.writing import write_together

BARE = re.compile(r"[A-Za-z0-9_-]+")
"""A TOML key that needs no quotes."""
# A long record must not fill the memory.
ROWS = 8192
"""Rows formatted at once."""


def write_campaign(campaign: Campaign, folder: Path | str) -> list[Path]:
    """Write a campaign made in code as files: campaign.toml, mechanism.toml and a CSV file for each record.

    Samples are written exactly as passed to `make_record`; units, gains and conditioning go to campaign.toml.
    `load_campaign` therefore restores the same campaign, and every command of ``mechid`` can use it.

    Parameters
    ----------
    campaign : Campaign
        Campaign of `make_campaign`.
    folder : Path
        Created with its parents if missing.

    Returns
    -------
    list of Path
        The files written; all or none.

    Raises
    ------
    UsageError
        The campaign was read from files, or the folder already holds one of the files or is not writable.

    Examples
    --------
    >>> import mechid
    >>> planned = mechid.make_record("full_46", command=mechid.make_command("full", rate=46.0))
    >>> campaign = mechid.make_campaign(mechid.catalogue_mechanism(), [planned])
    >>> [file.name for file in mechid.write_campaign(campaign, "bench")]  # doctest: +SKIP
    ['campaign.toml', 'mechanism.toml']
    """
    folder = Path(folder)
    if campaign.source is None:
        raise UsageError(f"{campaign.path}: the campaign is in files already; copy them")
    entries, samples = campaign.source.entries, campaign.source.samples
    files: dict[str, str | Iterable[str]] = {
        FILE_NAME: campaign_toml(entries, samples),
        MECHANISM_NAME: mechanism_text(campaign.mechanism),
    }
    for name, columns in samples.items():
        rated = next(record for record in entries["record"] if record["name"] == name).get("sample_rate_hz")
        files[f"{name}.csv"] = _csv(columns, timed=rated is None)
    # All files are checked first, so that none is written if one exists.
    there = next((name for name in files if (folder / name).exists()), None)
    if there:
        raise UsageError(f"{folder / there}: already exists; give another folder, or move it away")
    return write_together(folder, files)


def campaign_toml(entries: Mapping[str, Any], samples: Mapping[str, SampleColumns]) -> str:
    """Return campaign.toml for the inputs of `make_campaign`: single keys, then tables, records and stages."""
    # TOML assigns each key to the table above it, so keys of the whole file have to come first.
    single = {key: value for key, value in entries.items() if not _is_table(value)}
    blocks = [_pairs({"mechanism": MECHANISM_NAME, **single})]
    for key, value in entries.items():
        if isinstance(value, Mapping):
            blocks.append(f"[{_key(key)}]\n{_pairs(value)}")
    lists = [key for key, value in entries.items() if isinstance(value, list) and _is_table(value)]
    for key in dict.fromkeys(("record", "stage", *lists)):
        for table in entries.get(key, ()):
            own = {"file": f"{table['name']}.csv"} if key == "record" and table["name"] in samples else {}
            blocks.append(f"[[{key}]]\n{_pairs({**table, **own})}")
    return "\n".join(blocks)


def command_text(command: Command) -> str:
    """Return a command in the notation of a campaign file.

    Examples
    --------
    >>> from mechid.command import RateProfile
    >>> command_text(Command(stepping="micro", microsteps=16, rate=RateProfile.constant(46.0)))
    '{ stepping = "micro", microsteps = 16, rate = 46.0 }'
    """
    entries: dict[str, Any] = {"stepping": command.stepping}
    if command.stepping == "micro":
        entries["microsteps"] = command.microsteps
    times, rates = command.rate.times_s, command.rate.rates
    if len(times) == 1:
        entries["rate"] = rates[0]
    else:
        entries["rate_profile"] = [list(point) for point in zip(times, rates, strict=True)]
    default = Command(stepping=command.stepping, microsteps=command.microsteps, rate=command.rate)
    for key in ("start_angle_deg", "waveform", "start", "clock_tick_s"):
        if getattr(command, key) != getattr(default, key):
            entries[key] = getattr(command, key)
    if command.table:
        entries["table"] = [list(row) for row in command.table]
    return _value(entries)


def _csv(columns: SampleColumns, *, timed: bool) -> Iterator[str]:
    """Yield a record as CSV text in blocks: a header with units, then the unscaled numbers."""
    arrays = {name: array for name, array in columns.arrays.items() if timed or name != TIME}
    header = io.StringIO()
    units = (f" [{columns.units[name]}]" if name in columns.units else "" for name in arrays)
    csv.writer(header, lineterminator="\n").writerow([name + unit for name, unit in zip(arrays, units, strict=True)])
    yield header.getvalue()
    for start in range(0, len(next(iter(arrays.values()))), ROWS):
        block = [np.asarray(array[start : start + ROWS], dtype=np.float64).tolist() for array in arrays.values()]
        # repr is the shortest text that reads back to the same float.
        yield "".join(",".join(map(repr, row)) + "\n" for row in zip(*block, strict=True))


def _is_table(value: Any) -> bool:
    """Return whether an entry is written as a table or a list of tables."""
    return isinstance(value, Mapping) or (isinstance(value, list) and any(isinstance(v, Mapping) for v in value))


def _pairs(table: Mapping[str, Any]) -> str:
    return "".join(f"{_key(key)} = {_value(value)}\n" for key, value in table.items())


def _key(key: str) -> str:
    return key if BARE.fullmatch(key) else toml_text(key)


def _value(value: Any) -> str:
    """Return a value in TOML notation, on one line."""
    if isinstance(value, Command):
        return command_text(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return toml_number(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(key)} = {_value(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    return toml_text(value) if isinstance(value, str) else str(value)
