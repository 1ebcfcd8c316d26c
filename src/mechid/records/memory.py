"""Checks for sufficient memory and disk space before a file is read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from mechid.errors import RecordError
from mechid.reading.memory import GIB, limit_bytes
from mechid.signal.stored_series import WORD, free_bytes
from mechid.writing import cache_folder


def refuse_insufficient_disk(fault: Callable[[str], RecordError], samples: int, columns: int) -> None:
    """Raise an error if the disk has not enough space for the temporary files of samples.

    `fault` creates the error with the name of the record's file.

    Raises
    ------
    RecordError
        There is not enough disk space.
    """
    needed, there = WORD * samples * columns, free_bytes()
    if needed > there:
        raise fault(
            f"{samples} samples of {columns} columns need {needed / GIB:.3g} GiB of disk while they are read, "
            f"{there / GIB:.3g} GiB are free in {cache_folder()}; free some space, set MECHID_CACHE to another folder, "
            "or read a part with window_s"
        )


def refuse_larger_than_memory(path: Path, label: str, kind: str) -> None:
    """Raise an error if a file that can only be read as a whole exceeds the memory limit of the reading process.

    Raises
    ------
    RecordError
        The file is too large.
    """
    size, there = path.stat().st_size, limit_bytes()
    if there is not None and size > there:
        raise RecordError(
            f"{label}: {size / GIB:.3g} GiB, and reading it may take {there / GIB:.3g} GiB of memory; {kind} is read "
            "whole: save it as HDF5 or Parquet, of which a part can be read, or in several files"
        )
