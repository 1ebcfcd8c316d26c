"""What cannot be in memory at once is refused before the machine stands still."""

from __future__ import annotations

import os
from pathlib import Path

from mechid.errors import RecordError

GIB = 2**30


def memory_bytes() -> int | None:
    """Return the machine's memory in bytes, None where the system does not tell."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") if hasattr(os, "sysconf") else None


def refuse_larger_than_memory(path: Path, label: str, kind: str) -> None:
    """Refuse a file of a format that can only be read whole where it is larger than memory.

    Raises
    ------
    RecordError
        It is.
    """
    size, there = path.stat().st_size, memory_bytes()
    if there is not None and size > there:
        raise RecordError(
            f"{label}: {size / GIB:.3g} GiB, and there are {there / GIB:.3g} GiB of memory; {kind} is read whole: "
            "save it as HDF5 or Parquet, of which a part can be read, or in several files"
        )
