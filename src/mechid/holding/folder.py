"""A folder held by one run at a time."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from filelock import BaseFileLock, FileLock, SoftFileLock, Timeout

from mechid.errors import UnwritableError, UsageError
from mechid.holding.holder import Holder, read_holder, this_process
from mechid.holding.leftovers import LOCK_NAME, sweep
from mechid.reading.whole import read_text
from mechid.writing import creating_folder, is_unwritable_error, unwritable_error, write_atomically

_HELD: ContextVar[tuple[tuple[Path, str], ...]] = ContextVar("held", default=())
"""Folders that are held around what runs now, each with the token of its hold."""
_LOCKS: dict[Path, Holder] = {}
"""Lock files of this process, whichever thread holds their folders."""
GUARD_NAME = ".mechid.guard.lock"
"""Of the file that the system locks. The record is another one: Windows lets nobody read a file that is locked."""
MARKER_NAME = ".mechid.marker.lock"
"""Of the file whose being there is the lock, on file systems that lock no files."""
LOCK_FILES = ".mechid.*lock"
"""All three, as a shell takes it."""
NO_LOCKS = frozenset({errno.ENOSYS, errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP})
PATIENCE_S = 2.0
"""For the record of a run that has locked a folder an instant ago, or is about to let go of it."""
MOST_NAMED = 8
"""Of the files that a run has saved until it could write no more."""


@contextmanager
def hold_folder(folder: Path | str, *, within: str = "") -> Iterator[str]:
    """Hold a folder, made with its parents, against other runs; what a killed one left half-written is removed.

    The system's lock of a file goes with its process, so that a run that was killed is in nobody's way. A second file
    says who holds the folder; where it names another machine it counts too, since some network file systems lock for
    one machine alone. Who holds the folder already holds it on. A folder that was made for it, and in which nothing
    was written, is removed again.

    Parameters
    ----------
    folder : Path
    within : str
        Token of the hold for which this work is done: what another process held for the same one, and is on another
        machine, is taken over, since who gives work out a second time has given up the first.

    Yields
    ------
    str
        The token of the hold.

    Raises
    ------
    UsageError
        Another run holds it, who is said.
    UnwritableError
        It cannot be written to, or not any more; then with what has been saved in it.
    """
    place = Path(folder).absolute()
    around = dict(_HELD.get())
    if place in around:
        yield around[place]
        return
    with _made_if_used(place), creating_folder(folder):
        guard, own = _take(place / LOCK_NAME, Path(folder), within)
        _LOCKS[place / LOCK_NAME] = own
        reset = _HELD.set((*_HELD.get(), (place, own.token)))
        try:
            sweep(place)
            with _said(place, Path(folder)):
                yield own.token
        finally:
            _HELD.reset(reset)
            _let_go(place / LOCK_NAME, own)
            guard.release()  # after its file has gone: who waits for it then finds that it is nobody's
            _LOCKS.pop(place / LOCK_NAME, None)


def release_all() -> None:
    """Let go of all folders that this process holds, without what it has half-written there: it is about to end."""
    for lock, own in list(_LOCKS.items()):
        sweep(lock.parent, with_own=True)
        _let_go(lock, own)


@contextmanager
def _made_if_used(folder: Path) -> Iterator[None]:
    """Remove a folder, and its parents, again that were not there and in which nothing was left."""
    missing = [path for path in (folder, *folder.parents) if not os.path.lexists(path)]
    try:
        yield
    finally:
        for made in missing:
            with suppress(OSError):
                made.rmdir()


@contextmanager
def _said(place: Path, folder: Path) -> Iterator[None]:
    """Say of a folder that cannot be written to any more what has been saved in it since its lock file was."""
    began_ns = (place / LOCK_NAME).stat().st_mtime_ns
    try:
        yield
    except (UnwritableError, OSError) as error:
        if isinstance(error, OSError):
            if not is_unwritable_error(place, error):
                raise
            error = unwritable_error(folder, error)
        raise UnwritableError(f"{error}; {_saved_since(place, began_ns)}") from error


def _take(lock: Path, folder: Path, within: str) -> tuple[BaseFileLock, Holder]:
    """Lock a folder, and write who this process is; return both."""
    own = this_process(within)
    if _is_given_up(_holder(lock), within):
        for name in (GUARD_NAME, MARKER_NAME):  # new files have locks of their own
            lock.with_name(name).unlink(missing_ok=True)
    try:
        guard = _acquire_guard(lock)
    except Timeout:
        raise UsageError(_refusal(folder, _holder(lock))) from None
    try:
        found = _holder(lock)
        if found is not None and found.is_elsewhere and not _is_given_up(found, within):
            raise UsageError(_refusal(folder, found))
        write_atomically(lock, own.text())
    except BaseException:
        lock.with_name(GUARD_NAME).unlink(missing_ok=True)
        guard.release()
        raise
    return guard, own


def _is_given_up(found: Holder | None, within: str) -> bool:
    """Whether the work is given out again, since the machine that had it no longer answers."""
    return found is not None and found.is_elsewhere and bool(within) and found.within == within


def _acquire_guard(lock: Path) -> BaseFileLock:
    """Lock the file beside a record; Timeout where another run has it locked."""

    def is_known() -> bool:
        return _holder(lock) is not None

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
        remedy += f"; should it be gone, which cannot be seen from here, remove {folder / LOCK_FILES}"
    return f"{folder}: another run holds it{who}; {remedy}"


def _holder(lock: Path) -> Holder | None:
    try:
        return read_holder(read_text(lock))
    except (FileNotFoundError, UnicodeDecodeError):
        return None


def _let_go(lock: Path, own: Holder) -> None:
    """Remove the record and the locked file where they are still this hold's."""
    with suppress(OSError):
        found = _holder(lock)
        if found is not None and found.token == own.token:
            lock.unlink()
            lock.with_name(GUARD_NAME).unlink()


def _saved_since(folder: Path, instant_ns: int) -> str:
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
