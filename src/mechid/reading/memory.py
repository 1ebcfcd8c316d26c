"""Memory of the machine, and the memory limit of the reading process."""

from __future__ import annotations

import os

GIB = 2**30
MEMORY_DIVISOR = 2
"""The reading process may use the machine's memory divided by this: the caller holds a copy of the result."""


def memory_bytes() -> int | None:
    """Return the machine's memory in bytes, or None if the system does not report it."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") if hasattr(os, "sysconf") else None


def limit_bytes() -> int | None:
    """Return the memory limit of the reading process in bytes, or None if the system does not report its memory."""
    there = memory_bytes()
    return there // MEMORY_DIVISOR if there else None
