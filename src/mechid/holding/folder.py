"""Exclusive lock of a result folder, held by one run at a time."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from mechid.errors import UnwritableError, UsageError
from mechid.holding.holder import Holder, Life, read_holder, this_process
from mechid.holding.leftovers import LOCK_NAME, sweep
from mechid.reading.whole import read_text
from mechid.writing import creating_folder, is_unwritable_error, unwritable_error

_HELD: ContextVar[tuple[tuple[Path, str], ...]] = ContextVar("held", default=())
"""Folders held by the enclosing calls in this context, each with the token of its lock."""
_LOCKS: dict[Path, Holder] = {}
"""Lock files of this process, of all threads."""
MAX_NAMED_FILES = 8
"""Number of saved files that a message lists when a run can no longer write."""


@contextmanager
def hold_folder(folder: Path | str, *, within: str = "") -> Iterator[str]:
    """Lock a folder against other runs, and remove partial files left by a killed run.

    The folder and its parents are created if necessary. A lock file in the folder identifies the holder. The lock of a
    process that has ended, or whose process number has been reused, is taken over. The lock is reentrant. Folders
    created here are removed again if nothing was written in them.

    Parameters
    ----------
    folder : Path
    within : str
        Token of the enclosing lock for which the work is done, such as that of a fleet. A lock that a process on
        another machine holds for the same token is taken over: a dispatcher that assigns work again has abandoned the
        first assignment.

    Yields
    ------
    str
        Token of the lock.

    Raises
    ------
    UsageError
        Another run holds the folder; the message identifies it.
    UnwritableError
        The folder cannot be written to, or no longer; the message then lists the files saved so far.
    """
    place = Path(folder).absolute()
    around = dict(_HELD.get())
    if place in around:
        yield around[place]
        return
    with _remove_unused(place), creating_folder(folder):
        own = _LOCKS[place / LOCK_NAME] = _acquire_lock(place / LOCK_NAME, Path(folder), within)
        reset = _HELD.set((*_HELD.get(), (place, own.token)))
        try:
            sweep(place)
            with _add_saved_files(place, Path(folder)):
                yield own.token
        finally:
            _HELD.reset(reset)
            _release_lock(place / LOCK_NAME, own)
            _LOCKS.pop(place / LOCK_NAME, None)


def release_all() -> None:
    """Release all folders of this process and remove its partial files; call it just before the process ends."""
    for lock, own in list(_LOCKS.items()):
        sweep(lock.parent, with_own=True)
        _release_lock(lock, own)


@contextmanager
def _remove_unused(folder: Path) -> Iterator[None]:
    """Remove on exit the folder and those parents that did not exist on entry, if they are empty."""
    missing = [path for path in (folder, *folder.parents) if not os.path.lexists(path)]
    try:
        yield
    finally:
        for made in missing:
            # rmdir fails on a folder that is not empty, which keeps everything that was written.
            with suppress(OSError):
                made.rmdir()


@contextmanager
def _add_saved_files(place: Path, folder: Path) -> Iterator[None]:
    """Extend the error of a folder that can no longer be written to by the files saved since it was locked."""
    # Times are compared with that of the lock file, since the clock of a network drive may differ from the machine's.
    began_ns = (place / LOCK_NAME).stat().st_mtime_ns
    try:
        yield
    except (UnwritableError, OSError) as error:
        if isinstance(error, OSError):
            if not is_unwritable_error(place, error):
                raise
            error = unwritable_error(folder, error)
        raise UnwritableError(f"{error}; {_describe_saved_files(place, began_ns)}") from error


def _acquire_lock(lock: Path, folder: Path, within: str) -> Holder:
    """Write the lock file and return its content."""
    own = this_process(within)
    with _exclusive_access(lock.parent):
        while not _write_lock(lock, own):
            found = _read_lock(lock)
            if found is not None and _is_at_work(found, within):
                raise UsageError(_refusal(folder, found, lock))
            lock.unlink(missing_ok=True)
    return own


def _is_at_work(found: Holder, within: str) -> bool:
    life = found.life
    return life is Life.HERE or (life is Life.ELSEWHERE and (not within or found.within != within))


def _refusal(folder: Path, found: Holder, lock: Path) -> str:
    remedy = "wait until it ends, or choose another folder"
    if found.life is Life.ELSEWHERE:
        remedy += f"; if that run no longer exists (this machine cannot check), remove {folder / lock.name}"
    return f"{folder}: in use by another run: {found.words}; {remedy}"


def _write_lock(lock: Path, own: Holder) -> bool:
    """Write a complete lock file unless one exists, and return whether it was written."""
    beside = lock.with_name(f"{lock.name}.{own.token}.{own.pid}.part")
    try:
        beside.write_text(own.text(), encoding="utf-8")
        try:
            # A hard link appears atomically with its content and never replaces an existing file.
            lock.hardlink_to(beside)
        except FileExistsError:
            return False
        except OSError:  # the file system has no hard links
            return _create_exclusively(lock, own.text())
    finally:
        beside.unlink(missing_ok=True)
    return True


def _create_exclusively(lock: Path, text: str) -> bool:
    try:
        with lock.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        return False
    return True


def _read_lock(lock: Path) -> Holder | None:
    try:
        return read_holder(read_text(lock))
    except (FileNotFoundError, UnicodeDecodeError):
        return None


def _release_lock(lock: Path, own: Holder) -> None:
    """Remove the lock file if it still belongs to this lock."""
    with suppress(OSError):
        found = _read_lock(lock)
        if found is not None and found.token == own.token:
            lock.unlink()


@contextmanager
def _exclusive_access(folder: Path) -> Iterator[None]:
    """Serialise access of processes to the lock file of a folder, if the system supports it.

    Otherwise two runs that find the same stale lock file at the same instant may both take it over.
    """
    try:
        import fcntl

        handle = os.open(folder, os.O_RDONLY)
    except (ImportError, OSError):
        yield
        return
    try:
        # Some network file systems do not support locks on folders; the hard link still protects against most races.
        with suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def _describe_saved_files(folder: Path, instant_ns: int) -> str:
    """Return a phrase that lists the files written in a folder and its direct subfolders since an instant."""
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
    more = [f"{len(names) - MAX_NAMED_FILES} more"] if len(names) > MAX_NAMED_FILES else []
    return f"saved before: {', '.join([*names[:MAX_NAMED_FILES], *more])}"


def _is_fresh(path: Path, folder: Path, instant_ns: int) -> bool:
    """Return whether a path is a visible file that has been written since an instant."""
    is_hidden = any(part.startswith(".") for part in path.relative_to(folder).parts)
    return not is_hidden and path.is_file() and path.stat().st_mtime_ns >= instant_ns
