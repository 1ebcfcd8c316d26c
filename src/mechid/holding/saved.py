"""What a run has saved in its folder until it could write no more."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

MOST_NAMED = 8


def saved_since(folder: Path, instant_ns: int) -> str:
    """Return in words which files have been written in a folder, and right below it, since an instant of its clock."""
    fresh: list[Path] = []
    with suppress(OSError):
        fresh = [path for path in (*folder.iterdir(), *folder.glob("*/*")) if _is_fresh(path, folder, instant_ns)]
    names = sorted(path.name for path in fresh if path.parent == folder)
    counts = {
        place: sum(path.parent == place for path in fresh) for place in {path.parent for path in fresh} - {folder}
    }
    names += sorted(f"{count} of {place.name}/" for place, count in counts.items())
    if not names:
        return "nothing was saved"
    more = [f"{len(names) - MOST_NAMED} more"] if len(names) > MOST_NAMED else []
    return f"saved before: {', '.join([*names[:MOST_NAMED], *more])}"


def _is_fresh(path: Path, folder: Path, instant_ns: int) -> bool:
    """Whether a path is a file, not a hidden one, that has been written since."""
    is_hidden = any(part.startswith(".") for part in path.relative_to(folder).parts)
    return not is_hidden and path.is_file() and path.stat().st_mtime_ns >= instant_ns
