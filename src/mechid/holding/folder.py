"""A folder held by one run at a time."""

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
"""Folders that are held around what runs now, each with the token of its hold."""
_LOCKS: dict[Path, Holder] = {}
"""Lock files of this process, whichever thread holds their folders."""
MOST_NAMED = 8
"""Of the files that a run has saved until it could write no more."""


@contextmanager
def held(folder: Path | str, *, within: str = "") -> Iterator[str]:
    """Hold a folder, made with its parents, against other runs; what a killed one left half-written is removed.

    A file in the folder says who holds it. That of a process that has ended, or whose number another one has by now,
    is taken over. Who holds the folder already holds it on. A folder that was made for it, and in which nothing was
    written, is removed again.

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
        own = _LOCKS[place / LOCK_NAME] = _taken(place / LOCK_NAME, Path(folder), within)
        reset = _HELD.set((*_HELD.get(), (place, own.token)))
        try:
            sweep(place)
            with _said(place, Path(folder)):
                yield own.token
        finally:
            _HELD.reset(reset)
            _let_go(place / LOCK_NAME, own)
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


def _taken(lock: Path, folder: Path, within: str) -> Holder:
    """Write the lock file, and return who this process is in it."""
    own = this_process(within)
    with _one_at_a_time(lock.parent):
        while not _written(lock, own):
            found = _holder(lock)
            if found is not None and _is_at_work(found, within):
                raise UsageError(_refusal(folder, found, lock))
            lock.unlink(missing_ok=True)
    return own


def _is_at_work(found: Holder, within: str) -> bool:
    life = found.life
    return life is Life.HERE or (life is Life.ELSEWHERE and (not within or found.within != within))


def _refusal(folder: Path, found: Holder, lock: Path) -> str:
    remedy = "wait until it has ended, or give another folder"
    if found.life is Life.ELSEWHERE:
        remedy += f"; should it be gone, which cannot be seen from here, remove {folder / lock.name}"
    return f"{folder}: another run holds it: {found.words}; {remedy}"


def _written(lock: Path, own: Holder) -> bool:
    """Write a lock file as a whole if there is none, and return whether there was none."""
    beside = lock.with_name(f"{lock.name}.{own.token}.{own.pid}.part")
    try:
        beside.write_text(own.text(), encoding="utf-8")
        try:
            lock.hardlink_to(beside)  # in one step, and never onto one that is there
        except FileExistsError:
            return False
        except OSError:  # a file system without links
            return _created(lock, own.text())
    finally:
        beside.unlink(missing_ok=True)
    return True


def _created(lock: Path, text: str) -> bool:
    try:
        with lock.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        return False
    return True


def _holder(lock: Path) -> Holder | None:
    try:
        return read_holder(read_text(lock))
    except (FileNotFoundError, UnicodeDecodeError):
        return None


def _let_go(lock: Path, own: Holder) -> None:
    """Remove the lock file where it is still this hold's."""
    with suppress(OSError):
        found = _holder(lock)
        if found is not None and found.token == own.token:
            lock.unlink()


@contextmanager
def _one_at_a_time(folder: Path) -> Iterator[None]:
    """Let one process at a time look at the lock file of a folder and replace it, where the system can do that.

    Where it cannot, two runs that find the same stale file at the same instant may both take it for theirs.
    """
    try:
        import fcntl

        handle = os.open(folder, os.O_RDONLY)
    except (ImportError, OSError):
        yield
        return
    try:
        with suppress(OSError):  # some network file systems lock no folders
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


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
