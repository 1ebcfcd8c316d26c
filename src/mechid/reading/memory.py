"""How much memory there is, and how much of it reading a file may take."""

from __future__ import annotations

import os

GIB = 2**30
SHARE = 2
"""One part in so many of the machine's memory: what has been read is in memory where it is used, too."""


def memory_bytes() -> int | None:
    """Return the machine's memory in bytes, None where the system does not tell."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") if hasattr(os, "sysconf") else None


def limit_bytes() -> int | None:
    """Return what the process that reads may hold, in bytes; None where the system does not tell."""
    there = memory_bytes()
    return there // SHARE if there else None
