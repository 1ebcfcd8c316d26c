"""Kernels as they are kept on disk: known to be whole by their digests, and made by one process at a time."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from mechid.writing import write_atomically

TAG = f".py{sys.version_info.major}{sys.version_info.minor}."
"""Of this version of Python, in the names that Numba gives."""


def is_whole(path: Path) -> bool:
    """Whether a kernel's source and all that was compiled of it are as they were written.

    Machine code that is cut off or changed ends Python when it is loaded, so it is never loaded.
    """
    sealed = _sealed(path)
    return path.name in sealed and _own(sealed, path) == _own(_digests(path), path)


def is_sealed(path: Path) -> bool:
    """Whether it was noted what a kernel's files hold."""
    return _seal(path).is_file()


def seal(path: Path) -> None:
    """Note what a kernel's files hold; where nothing can be written, as in a cache that others share, nothing is."""
    with suppress(OSError):
        if not is_whole(path):
            write_atomically(_seal(path), json.dumps(_digests(path)) + "\n")


def forget(path: Path) -> None:
    """Remove a kernel with all that was compiled of it, also by other versions of Python.

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


def _sealed(path: Path) -> dict[str, str]:
    try:
        found = json.loads(_seal(path).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _own(digests: Mapping[str, str], path: Path) -> dict[str, str]:
    """Return the digests of the source and of what this version of Python loads; others' come and go beside it."""
    return {name: digest for name, digest in digests.items() if name == path.name or TAG in name}


def _files(path: Path) -> list[Path]:
    """Return the files of a kernel: its source, Numba's indices, machine code; those at work beside them left out."""
    compiled = path.parent.glob(f"__pycache__/{path.stem}.*")
    return [file for file in (path, *sorted(compiled)) if file.suffix in (".py", ".nbi", ".nbc") and file.is_file()]


def _digests(path: Path) -> dict[str, str]:
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in _files(path)}
