"""Search for files with given names below a folder, visiting each folder once."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator
from pathlib import Path

# These folders contain many files and no results of their own.
PASSED_OVER = frozenset({"figures", "csv"})
"""Skipped folders, which contain parts of a result."""


def files_below(root: Path, names: Collection[str], unreadable: list[str]) -> Iterator[Path]:
    """Yield the files with one of the names, folder by folder in alphabetical order.

    Links are followed; a folder reached by several links, as in a cycle, is visited once. Hidden folders are skipped.

    Parameters
    ----------
    root : Path
    names : collection of str
    unreadable : list of str
        Receives the folders that cannot be listed.
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
        # The list is a stack: reversed, its folders are visited in alphabetical order.
        left += reversed(below)


def _is_visited(entry: os.DirEntry[str]) -> bool:
    try:
        return not entry.name.startswith(".") and entry.name not in PASSED_OVER and entry.is_dir()
    # Raised for a link to itself.
    except OSError:
        return False


def _identity(folder: Path) -> tuple[int, int]:
    try:
        found = folder.stat()
    except OSError:
        return (-1, -1)
    # Device and inode identify a folder, whatever path leads to it.
    return (found.st_dev, found.st_ino)
