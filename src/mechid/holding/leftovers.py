"""Half-written leftovers of a killed run in a result folder: files and folders that were to be renamed."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

LOCK_NAME = ".mechid.lock"
"""Of the file that says who holds a folder."""
PART = re.compile(r"\..+\.(?P<pid>\d+)\.part")
"""Name of a file, or a folder, beside its place, as `mechid.writing` gives it."""


def sweep(folder: Path, *, with_own: bool = False) -> list[Path]:
    """Remove what was left half-written in a folder and in the folders right in it, and return what it was.

    What a process of this number is at work on stays; what cannot be removed, too. `with_own` removes also what this
    process is at work on, which is about to end.
    """
    found = [path for place in (folder, *_folders(folder)) for path in _left(place, with_own=with_own)]
    for path in found:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path, ignore_errors=True)
        else:
            with suppress(OSError):
                path.unlink()
    return found


def _folders(folder: Path) -> Iterator[Path]:
    """Yield the folders in a folder, without links, which lead to what is others', and those held by themselves."""
    with suppress(OSError):
        for path in folder.iterdir():
            if path.is_dir() and not path.is_symlink() and not (path / LOCK_NAME).exists():
                yield path


def _left(folder: Path, *, with_own: bool) -> Iterator[Path]:
    with suppress(OSError):
        for path in folder.iterdir():
            part = PART.fullmatch(path.name)
            if part and (not _is_running(pid := int(part["pid"])) or (with_own and pid == os.getpid())):
                yield path


def _is_running(pid: int) -> bool:
    """Whether a process of this number is there; one that has ended, and whose end nobody has asked for, is not."""
    import psutil  # loaded only where something was left

    try:
        return bool(psutil.Process(pid).status() != psutil.STATUS_ZOMBIE)
    except (psutil.NoSuchProcess, OverflowError):
        return False
    except psutil.AccessDenied:  # another user's
        return True
