"""Integrity of cached kernel files: verified by digests, compiled by one process at a time."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from mechid.writing import write_atomically

TAG = f".py{sys.version_info.major}{sys.version_info.minor}."
"""Marks files of this version of Python in the names that Numba chooses."""


def is_whole(path: Path) -> bool:
    """Return whether a kernel's source and its compiled files are as they were written.

    Loading truncated or altered machine code crashes Python, so such files are never loaded.
    """
    sealed = _stored_digests(path)
    return path.name in sealed and _own_digests(sealed, path) == _own_digests(_digests(path), path)


def is_sealed(path: Path) -> bool:
    """Return whether the digests of a kernel's files have been stored."""
    return _seal(path).is_file()


def seal(path: Path) -> None:
    """Store the digests of a kernel's files; do nothing where writing is impossible, as in a shared read-only cache."""
    with suppress(OSError):
        if not is_whole(path):
            write_atomically(_seal(path), json.dumps(_digests(path)) + "\n")


def remove_kernel(path: Path) -> None:
    """Remove a kernel with all its compiled files, including those of other versions of Python.

    Raises
    ------
    OSError
        A file cannot be removed.
    """
    for file in (_seal(path), *_files(path)):
        file.unlink(missing_ok=True)


@contextmanager
def lock_kernel(path: Path) -> Iterator[None]:
    """Let one process at a time compile a kernel; the lock is released however that process ends.

    Without file locks on the system, two processes may do the same work, one of them in vain.
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
            # The system releases the lock when the process ends, so that none is left behind by a crash.
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _seal(path: Path) -> Path:
    return path.with_suffix(".sums")


def _stored_digests(path: Path) -> dict[str, str]:
    try:
        found = json.loads(_seal(path).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _own_digests(digests: Mapping[str, str], path: Path) -> dict[str, str]:
    """Return the digests of the source and of the files that this version of Python loads; others may change."""
    # Another version of Python adds its files to the same folder; they must not invalidate these.
    return {name: digest for name, digest in digests.items() if name == path.name or TAG in name}


def _files(path: Path) -> list[Path]:
    """Return the files of a kernel (source, Numba's indices, machine code), without temporary files."""
    compiled = path.parent.glob(f"__pycache__/{path.stem}.*")
    return [file for file in (path, *sorted(compiled)) if file.suffix in (".py", ".nbi", ".nbc") and file.is_file()]


def _digests(path: Path) -> dict[str, str]:
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in _files(path)}
