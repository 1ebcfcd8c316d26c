"""Examination of several sources: measured files, and campaigns with the commands of their records."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

from mechid.analysis.look import Drive, RecordLook, look_at
from mechid.campaign.campaign import Campaign, CampaignRecord
from mechid.campaign.campaign_file import FILE_NAME, load_named_lines, load_phases, load_records
from mechid.campaign.campaign_in_code import RecordEntry, read_single_record
from mechid.display import DisplayedResult
from mechid.errors import RecordError
from mechid.plant.mechanism import NamedLine
from mechid.records import Record
from mechid.records.undeclared import Hints, read_bare

TOML = ".toml"
_NO_NAME = re.compile(r"[^A-Za-z0-9_-]+")


@dataclass(frozen=True, kw_only=True)
class UnreadableFile:
    """A file that could not be read, with the reason."""

    file: str
    message: str


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Survey(DisplayedResult):
    """Examinations of all records, with unique names, and the files that could not be read."""

    looks: tuple[RecordLook, ...]
    left_out: tuple[UnreadableFile, ...]


Source: TypeAlias = Path | Campaign | RecordEntry


def survey(sources: Sequence[Source], hints: Hints | None = None) -> Survey:
    """Examine measured files and the records of campaigns.

    Parameters
    ----------
    sources : sequence of Path, Campaign or RecordEntry
        Measured files, campaign files, or folders that hold ``campaign.toml``; campaigns and records in memory.
    hints : Hints or None
        Hints on the columns of the measured files; campaigns need none.

    Raises
    ------
    InputFileError
        A campaign file is invalid.
    RecordError
        No file can be read; the message gives the reason of the first one.
    """
    looks: list[RecordLook] = []
    left_out: list[UnreadableFile] = []
    used: set[str] = set()
    for source in sources:
        try:
            for record, drive in _records(source, hints):
                looks.append(look_at(replace(record, name=_unique_name(record.name, used)), drive))
        # One unreadable file must not prevent the examination of the others.
        except RecordError as error:
            left_out.append(
                UnreadableFile(file=str(source) if isinstance(source, Path) else _name(source), message=str(error))
            )
    if not looks:
        more = f"; and {len(left_out) - 1} more files" if len(left_out) > 1 else ""
        raise RecordError(f"{left_out[0].message}{more}" if left_out else "no records")
    return Survey(looks=tuple(looks), left_out=tuple(left_out))


def _records(source: Source, hints: Hints | None) -> Iterator[tuple[Record, Drive | None]]:
    """Yield the records of a source, each with its declared drive."""
    if isinstance(source, RecordEntry):
        record, command = read_single_record(source)
        yield record, Drive(command=command) if command else None
        return
    if isinstance(source, Campaign):
        named = source.mechanism.named_lines
        yield from ((_data(record), _drive(record, named)) for record in source.records)
        return
    path = source
    if path.suffix.lower() == TOML or (path / FILE_NAME).is_file():
        named, phases = load_named_lines(path), load_phases(path)
        for one in load_records(path):
            drive = _drive(one, named)
            yield _data(one), replace(drive, command=drive.command.for_motor(phases))
    else:
        yield from ((record, None) for record in read_bare(path, hints))


def _name(source: Campaign | RecordEntry) -> str:
    return source.name if isinstance(source, RecordEntry) else str(source.path)


def _data(record: CampaignRecord) -> Record:
    if record.data is None:
        raise RecordError(f'record "{record.name}": it has no file')
    return record.data


def _drive(record: CampaignRecord, named: tuple[NamedLine, ...]) -> Drive:
    return Drive(command=record.command, time_offset_s=record.time_offset.value, named=named)


def _unique_name(name: str, used: set[str]) -> str:
    """Return an unused name that can serve as a file name, and add it to the used ones."""
    plain = _NO_NAME.sub("_", name).strip("_") or "record"
    names = (plain, *(f"{plain}_{k}" for k in range(2, len(used) + 3)))
    own = next(one for one in names if one.casefold() not in used)
    used.add(own.casefold())
    return own
