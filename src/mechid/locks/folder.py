"""Exclusive lock of a result folder, held by one run at a time."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from filelock import BaseFileLock, FileLock, SoftFileLock, Timeout

from mechid.errors import UnwritableError, UsageError
from mechid.locks.holder import Holder, read_holder, this_process
from mechid.locks.leftovers import LOCK_NAME, sweep
from mechid.reading.whole import read_text
from mechid.writing import creating_folder, is_unwritable_error, unwritable_error, write_atomically

_HELD: ContextVar[tuple[tuple[Path, str], ...]] = ContextVar("held", default=())
"""Folders held by the enclosing calls in this context, each with the token of its lock."""
_LOCKS: dict[Path, Holder] = {}
"""Lock records of this process, of all threads."""
GUARD_NAME = ".mechid.guard.lock"
"""Name of the file that the system locks. It is separate from the record: Windows denies reading of locked files."""
MARKER_NAME = ".mechid.marker.lock"
"""Name of the file whose existence is the lock, on file systems without file locks."""
LOCK_FILES = ".mechid.*lock"
"""Shell pattern of record, guard and marker."""
NO_LOCKS = frozenset({errno.ENOSYS, errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP})
PATIENCE_S = 2.0
"""Waiting time for the record of a run that has just locked a folder or is about to release it."""
MOST_NAMED = 8
"""Number of saved files that a message lists when a run can no longer write."""


@contextmanager
def hold_folder(folder: Path | str, *, within: str = "") -> Iterator[str]:
    """Lock a folder against other runs, and remove partial files left by a killed run.

    The folder and its parents are created if necessary. The system releases a file lock when its process ends, so a
    killed run blocks nobody. A record in a second file identifies the holder. A record of another machine counts as a
    lock too, because some network file systems lock files on one machine only. The lock is reentrant. Folders created
    here are removed again if nothing was written in them.

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
        guard, own = _take(place / LOCK_NAME, Path(folder), within)
        _LOCKS[place / LOCK_NAME] = own
        reset = _HELD.set((*_HELD.get(), (place, own.token)))
        try:
            sweep(place)
            with _add_saved_files(place, Path(folder)):
                yield own.token
        finally:
            _HELD.reset(reset)
            _release_record(place / LOCK_NAME, own)
            # Released after the record is removed, so that a waiting run finds a folder without a holder.
            guard.release()
            _LOCKS.pop(place / LOCK_NAME, None)


def release_all() -> None:
    """Release all folders of this process and remove its partial files; call it just before the process ends."""
    for lock, own in list(_LOCKS.items()):
        sweep(lock.parent, with_own=True)
        _release_record(lock, own)


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
    # Times are compared with that of the record, since the clock of a network drive may differ from the machine's.
    began_ns = (place / LOCK_NAME).stat().st_mtime_ns
    try:
        yield
    except (UnwritableError, OSError) as error:
        if isinstance(error, OSError):
            if not is_unwritable_error(place, error):
                raise
            error = unwritable_error(folder, error)
        raise UnwritableError(f"{error}; {_describe_saved_files(place, began_ns)}") from error


def _take(lock: Path, folder: Path, within: str) -> tuple[BaseFileLock, Holder]:
    """Lock a folder and write the record of this process; return the lock and the record."""
    own = this_process(within)
    if _is_given_up(_read_record(lock), within):
        # New files have new locks, whatever the other machine still holds.
        for name in (GUARD_NAME, MARKER_NAME):
            lock.with_name(name).unlink(missing_ok=True)
    try:
        guard = _acquire_guard(lock)
    except Timeout:
        raise UsageError(_refusal(folder, _read_record(lock))) from None
    try:
        found = _read_record(lock)
        if found is not None and found.is_elsewhere and not _is_given_up(found, within):
            raise UsageError(_refusal(folder, found))
        write_atomically(lock, own.text())
    except BaseException:
        lock.with_name(GUARD_NAME).unlink(missing_ok=True)
        guard.release()
        raise
    return guard, own


def _is_given_up(found: Holder | None, within: str) -> bool:
    """Return whether the work of another machine has been assigned again, for the same enclosing lock."""
    return found is not None and found.is_elsewhere and bool(within) and found.within == within


def _acquire_guard(lock: Path) -> BaseFileLock:
    """Lock the guard file of a record; raise Timeout if another run has locked it."""

    def is_known() -> bool:
        return _read_record(lock) is not None

    guard: BaseFileLock = FileLock(lock.with_name(GUARD_NAME), thread_local=False, fallback_to_soft=False)
    try:
        guard.acquire(timeout=PATIENCE_S, cancel_check=is_known)
    except OSError as error:
        if error.errno not in NO_LOCKS:
            raise
        guard = SoftFileLock(lock.with_name(MARKER_NAME), thread_local=False)
        guard.acquire(timeout=PATIENCE_S, cancel_check=is_known)
    return guard


def _refusal(folder: Path, found: Holder | None) -> str:
    who = f": {found.words}" if found else ""
    remedy = "wait until it has ended, or give another folder"
    if found and found.is_elsewhere:
        remedy += f"; if that run no longer exists, which this machine cannot check, remove {folder / LOCK_FILES}"
    return f"{folder}: another run is using it{who}; {remedy}"


def _read_record(lock: Path) -> Holder | None:
    try:
        return read_holder(read_text(lock))
    except (FileNotFoundError, UnicodeDecodeError):
        return None


def _release_record(lock: Path, own: Holder) -> None:
    """Remove the record and the guard file if they still belong to this lock."""
    with suppress(OSError):
        found = _read_record(lock)
        if found is not None and found.token == own.token:
            lock.unlink()
            lock.with_name(GUARD_NAME).unlink()


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
    more = [f"{len(names) - MOST_NAMED} more"] if len(names) > MOST_NAMED else []
    return f"saved before: {', '.join([*names[:MOST_NAMED], *more])}"


def _is_fresh(path: Path, folder: Path, instant_ns: int) -> bool:
    """Return whether a path is a visible file that has been written since an instant."""
    is_hidden = any(part.startswith(".") for part in path.relative_to(folder).parts)
    return not is_hidden and path.is_file() and path.stat().st_mtime_ns >= instant_ns
