"""What a run has saved in its folder until it could write no more."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TypeAlias

Left: TypeAlias = "dict[Path, tuple[int, int]]"
"""Files of a folder and of the folders right in it, by path: the inode, and when it was written to, in ns."""
MOST_NAMED = 8


def left_in(folder: Path) -> Left:
    """Return the files that are in a folder, and in the folders right in it; hidden ones do not count."""
    found: Left = {}
    with suppress(OSError):
        for path in (*folder.iterdir(), *folder.glob("*/*")):
            if not any(part.startswith(".") for part in path.relative_to(folder).parts) and path.is_file():
                about = path.stat()
                found[path] = (about.st_ino, about.st_mtime_ns)
    return found


def saved_since(folder: Path, before: Left) -> str:
    """Return in words which files have been written since a folder was looked at."""
    fresh = [path for path, state in left_in(folder).items() if before.get(path) != state]
    names = sorted(path.name for path in fresh if path.parent == folder)
    counts = {
        place: sum(path.parent == place for path in fresh) for place in {path.parent for path in fresh} - {folder}
    }
    names += sorted(f"{count} of {place.name}/" for place, count in counts.items())
    if not names:
        return "nothing was saved"
    more = [f"{len(names) - MOST_NAMED} more"] if len(names) > MOST_NAMED else []
    return f"saved before: {', '.join([*names[:MOST_NAMED], *more])}"
