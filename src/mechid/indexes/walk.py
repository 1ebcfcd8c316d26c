"""Files of given names below a folder, each folder visited once."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator
from pathlib import Path

PASSED_OVER = frozenset({"figures", "csv"})
"""Folders that hold parts of a result."""


def files_below(root: Path, names: Collection[str], unreadable: list[str]) -> Iterator[Path]:
    """Yield the files with one of some names, folder by folder, in the order of their names.

    Links are followed; a folder that several lead to, as in a circle, is visited once. Hidden folders are passed over.

    Parameters
    ----------
    root : Path
    names : collection of str
    unreadable : list of str
        Takes up the folders that cannot be listed.
    """
    left, visited = [root], {_identity(root)}
    while left:
        folder = left.pop()
        try:
            with os.scandir(folder) as listed:
                entries = sorted(listed, key=lambda entry: entry.name)
        except OSError:
            unreadable.append(str(folder))
            continue
        below: list[Path] = []
        for entry in entries:
            if entry.name in names:
                yield folder / entry.name
            elif _is_visited(entry) and (identity := _identity(Path(entry.path))) not in visited:
                visited.add(identity)
                below.append(folder / entry.name)
        left += reversed(below)


def _is_visited(entry: os.DirEntry[str]) -> bool:
    try:
        return not entry.name.startswith(".") and entry.name not in PASSED_OVER and entry.is_dir()
    except OSError:  # a link that leads to itself
        return False


def _identity(folder: Path) -> tuple[int, int]:
    try:
        found = folder.stat()
    except OSError:
        return (-1, -1)
    return (found.st_dev, found.st_ino)
