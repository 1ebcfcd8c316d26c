"""Removal of partial files and folders that a killed run left in a result folder before renaming them."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

LOCK_NAME = ".mechid.lock"
"""Name of the record that identifies the holder of a folder."""
PART = re.compile(r"\..+\.(?P<pid>\d+)\.part")
"""Name of a partial file or folder, as given by `mechid.writing`."""


def sweep(folder: Path, *, with_own: bool = False) -> list[Path]:
    """Remove partial files and folders from a folder and its direct subfolders, and return their paths.

    Partial files of a running process are kept, and so are files that cannot be removed. With `with_own`, those of
    this process are removed too; use it only when the process is about to end.
    """
    found = [path for place in (folder, *_folders(folder)) for path in _leftovers(place, with_own=with_own)]
    for path in found:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path, ignore_errors=True)
        else:
            with suppress(OSError):
                path.unlink()
    return found


def _folders(folder: Path) -> Iterator[Path]:
    """Yield the subfolders of a folder that have no lock of their own."""
    # Links are skipped because their targets may belong to others.
    with suppress(OSError):
        for path in folder.iterdir():
            if path.is_dir() and not path.is_symlink() and not (path / LOCK_NAME).exists():
                yield path


def _leftovers(folder: Path, *, with_own: bool) -> Iterator[Path]:
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
