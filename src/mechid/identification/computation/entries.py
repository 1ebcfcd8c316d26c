"""The lines of a journal: each with a digest of itself, so that one that was damaged is told from one that is whole."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mechid.errors import UsageError

STARTED, STEP = "started", "step"
SEPARATOR = b', "check": "'
"""What stands before the digest, the last of a line."""
DIGITS = 16
"""Hexadecimal ones, of a line's digest: a line that was damaged passes once in 2e19."""
NEEDED: Mapping[str, Mapping[str, type | tuple[type, ...]]] = {
    STARTED: {"inputs": dict},
    STEP: {"step": str, "key": str, "seconds": (int, float), "result": object, "rng": object},
}
"""Keys that an event's line has to have, and of which type."""


def sealed(entry: Mapping[str, object]) -> str:
    """Return the line of an entry, its digest at the end.

    Examples
    --------
    >>> sealed({"event": "resumed"})
    '{"event": "resumed", "check": "497a82e0605ef488"}'
    """
    text = json.dumps(entry)
    return f'{text[:-1]}{SEPARATOR.decode()}{_digest(text.encode())}"}}'


def entries_of(path: Path, *, mends: bool = True) -> tuple[list[dict[str, Any]], str]:
    """Return the whole entries of a journal in their order, and what was damaged in a line; none of a missing file.

    Parameters
    ----------
    path : Path
    mends : bool
        Whether a last line that was not written to its end is cut off in the file.

    Raises
    ------
    UsageError
        No line is an entry, nor was one of an earlier version's: it is another file.
    """
    if not path.exists():
        return [], ""
    content = path.read_bytes()
    whole = content[: content.rfind(b"\n") + 1]
    if mends and len(whole) < len(content):
        os.truncate(path, len(whole))
    found = [_entry(line) for line in whole.splitlines()]
    lines = [entry for entry in found if entry is not None]
    damaged = [number for number, entry in enumerate(found, 1) if entry is None]
    if damaged and not lines:
        if not any(map(_is_earlier, whole.splitlines())):
            raise UsageError(f"{path}: line {damaged[0]}: is no entry of a journal; move the file away")
        return [], f"{path}: was begun by an earlier version of mechid; its lines stay, and their steps are done again"
    return lines, _notice(path, damaged)


def _entry(line: bytes) -> dict[str, Any] | None:
    """Return the entry of a line; None of one that is damaged, or of another program."""
    text, _, check = line.rpartition(SEPARATOR)
    if check != f'{_digest(text + b"}")}"}}'.encode():
        return None
    try:
        entry = json.loads(text + b"}")
    except (ValueError, RecursionError):
        return None
    if not isinstance(entry, dict) or not isinstance(entry.get("event"), str):
        return None
    needed = NEEDED.get(entry["event"], {})
    return entry if all(key in entry and isinstance(entry[key], kind) for key, kind in needed.items()) else None


def _is_earlier(line: bytes) -> bool:
    """Tell whether a line is an entry as versions wrote them that gave no digests."""
    try:
        entry = json.loads(line)
    except (ValueError, RecursionError):
        return False
    return isinstance(entry, dict) and isinstance(entry.get("event"), str) and "check" not in entry


def _digest(text: bytes) -> str:
    return hashlib.sha256(text).hexdigest()[:DIGITS]


def _notice(path: Path, damaged: list[int]) -> str:
    if not damaged:
        return ""
    lines = (
        f"line {damaged[0]} is" if len(damaged) == 1 else f"{len(damaged)} lines, the first of them {damaged[0]}, are"
    )
    return f"{path}: {lines} damaged and left out; what stood there is worked out again"
