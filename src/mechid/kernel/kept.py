"""Kernels as they are kept on disk: known to be whole by their digests, and made by one process at a time."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from mechid.writing import write_whole


def is_whole(path: Path) -> bool:
    """Whether a kernel's source and all that was compiled of it are as they were written.

    Machine code that is cut off or changed ends Python when it is loaded, so it is never loaded.
    """
    try:
        sealed = json.loads(_seal(path).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return bool(sealed) and sealed == _digests(path)


def is_sealed(path: Path) -> bool:
    """Whether it was noted what a kernel's files hold."""
    return _seal(path).is_file()


def seal(path: Path) -> None:
    """Note what a kernel's files hold; where nothing can be written, as in a cache that others share, nothing is."""
    with suppress(OSError):
        if not is_whole(path):
            write_whole(_seal(path), json.dumps(_digests(path)) + "\n")


def forget(path: Path) -> None:
    """Remove a kernel with all that was compiled of it.

    Raises
    ------
    OSError
        It cannot be removed.
    """
    for file in (_seal(path), *_files(path)):
        file.unlink(missing_ok=True)


@contextmanager
def one_process(path: Path) -> Iterator[None]:
    """Let one process at a time make a kernel; it is free again when that process ends, in whatever way.

    Where the system cannot do that two processes may do the same work, the second in vain.
    """
    try:
        import fcntl

        path.parent.mkdir(parents=True, exist_ok=True)
        file = path.with_suffix(".lock").open("w", encoding="utf-8")
    except (ImportError, OSError):
        yield
        return
    with file:
        with suppress(OSError):
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _seal(path: Path) -> Path:
    return path.with_suffix(".sums")


def _files(path: Path) -> list[Path]:
    """Return the files of a kernel: its source, Numba's indices, machine code; those at work beside them left out."""
    compiled = path.parent.glob(f"__pycache__/{path.stem}.*")
    return [file for file in (path, *sorted(compiled)) if file.suffix in (".py", ".nbi", ".nbc") and file.is_file()]


def _digests(path: Path) -> dict[str, str]:
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in _files(path)}
