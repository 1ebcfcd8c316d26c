"""What cannot be in memory, or on the disk while it is read, is refused before the machine stands still."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from mechid.errors import RecordError
from mechid.reading.memory import GIB, limit_bytes
from mechid.signal.stored import WORD, free_bytes
from mechid.writing import cache_folder


def refuse_insufficient_disk(fault: Callable[[str], RecordError], samples: int, columns: int) -> None:
    """Refuse samples that are to be kept in a temporary file, and for which there is no room on the disk.

    `fault` makes the error that says which file they are in.

    Raises
    ------
    RecordError
        There is none.
    """
    needed, there = WORD * samples * columns, free_bytes()
    if needed > there:
        raise fault(
            f"{samples} samples of {columns} columns need {needed / GIB:.3g} GiB of disk while they are read, "
            f"{there / GIB:.3g} GiB are free in {cache_folder()}; make room, name another folder in MECHID_CACHE, or "
            "read a part with window_s"
        )


def refuse_larger_than_memory(path: Path, label: str, kind: str) -> None:
    """Refuse a file of a format that can only be read whole where it is larger than what reading may take.

    Raises
    ------
    RecordError
        It is.
    """
    size, there = path.stat().st_size, limit_bytes()
    if there is not None and size > there:
        raise RecordError(
            f"{label}: {size / GIB:.3g} GiB, and reading it may take {there / GIB:.3g} GiB of memory; {kind} is read "
            "whole: save it as HDF5 or Parquet, of which a part can be read, or in several files"
        )
