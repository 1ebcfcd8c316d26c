"""All records that a user points at, looked at: bare files, and the records of a campaign with their commands."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from mechid.analysis.look import Drive, RecordLook, look_at
from mechid.campaign.campaign import CampaignRecord
from mechid.campaign.campaign_file import FILE_NAME, load_records
from mechid.errors import RecordError
from mechid.records import Record
from mechid.records.bare import Hints, read_bare

TOML = ".toml"
_NO_NAME = re.compile(r"[^A-Za-z0-9_-]+")


@dataclass(frozen=True, kw_only=True)
class LeftOut:
    """A file that could not be read, and why."""

    file: str
    message: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Survey:
    """The looks at all records, their names unlike, and the files that could not be read."""

    looks: tuple[RecordLook, ...]
    left_out: tuple[LeftOut, ...]


def survey(paths: Sequence[Path], hints: Hints | None = None) -> Survey:
    """Look at measured files and at the records of campaigns.

    Parameters
    ----------
    paths : sequence of Path
        Measured files, campaign files, or folders that hold ``campaign.toml``.
    hints : Hints or None
        On the columns of the measured files; a campaign says that itself.

    Raises
    ------
    InputFileError
        A campaign file is wrong.
    RecordError
        No file can be read; with the first one's reason.
    """
    looks: list[RecordLook] = []
    left_out: list[LeftOut] = []
    taken: set[str] = set()
    for path in paths:
        try:
            for record, drive in _records(path, hints):
                looks.append(look_at(replace(record, name=_unlike(record.name, taken)), drive))
        except RecordError as error:
            left_out.append(LeftOut(file=str(path), message=str(error)))
    if not looks:
        more = f"; and {len(left_out) - 1} more files" if len(left_out) > 1 else ""
        raise RecordError(f"{left_out[0].message}{more}" if left_out else "no records")
    return Survey(looks=tuple(looks), left_out=tuple(left_out))


def _records(path: Path, hints: Hints | None) -> Iterator[tuple[Record, Drive | None]]:
    """Yield the records of a path, each with the command that is declared of it."""
    if path.suffix.lower() == TOML or (path / FILE_NAME).is_file():
        yield from ((_data(record), _drive(record)) for record in load_records(path))
    else:
        yield from ((record, None) for record in read_bare(path, hints))


def _data(record: CampaignRecord) -> Record:
    if record.data is None:
        raise RecordError(f'record "{record.name}": it has no file')
    return record.data


def _drive(record: CampaignRecord) -> Drive:
    return Drive(command=record.command, time_offset_s=record.time_offset.value)


def _unlike(name: str, taken: set[str]) -> str:
    """Return a name that is a file name and not taken, and take it."""
    plain = _NO_NAME.sub("_", name).strip("_") or "record"
    names = (plain, *(f"{plain}_{k}" for k in range(2, len(taken) + 3)))
    own = next(one for one in names if one.casefold() not in taken)
    taken.add(own.casefold())
    return own
