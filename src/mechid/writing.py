"""Files that are there whole or as they were, and a folder that cannot be written to as the user's error."""

from __future__ import annotations

import errno
import io
import os
import shutil
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

import platformdirs

from mechid.errors import UnwritableError, UsageError

CACHE = "MECHID_CACHE"
"""Variable of the environment that names another folder for kernels and for the samples of long records."""
NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
NO_ROOM_WORDS = os.strerror(errno.ENOSPC)
_READ: ContextVar[set[Path] | None] = ContextVar("read", default=None)
"""The user's files that have been read by the command that runs; None where none does."""


def cache_folder() -> Path:
    """Return mechid's own folder for what is kept or set aside: the one that `CACHE` names, else the user's cache."""
    named = os.environ.get(CACHE)
    return Path(named) if named else Path(platformdirs.user_cache_dir("mechid"))


@contextmanager
def keeping_what_is_read() -> Iterator[None]:
    """Within a command, refuse to replace the files that `keep` names, whatever a result is called."""
    reset = _READ.set(set())
    try:
        yield
    finally:
        _READ.reset(reset)


def keep(path: Path) -> None:
    """Note a file of the user's that is read: no result of the same command takes its place."""
    read = _READ.get()
    if read is not None:
        read.add(path.resolve())


def refuse_read(path: Path) -> None:
    """Raise UsageError where a file to be written is one that the command has read."""
    if path.resolve() in (_READ.get() or ()):
        raise UsageError(f"{path}: is one of the files that were read, and is not replaced; give another folder")


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Yield a place beside `path` to write to, which is renamed at the end; nothing of it stays where that fails.

    Raises
    ------
    UsageError
        The file there has been read by this command.
    """
    refuse_read(path)
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield beside
        beside.replace(path)
    except OSError as error:
        raise placed(error, path) from None
    finally:
        beside.unlink(missing_ok=True)


@contextmanager
def aside(folder: Path, name: str) -> Iterator[Path]:
    """Yield an empty folder within another, for files that are put in their place when all are whole; then it goes."""
    beside = folder / f".{name}.{os.getpid()}.part"
    shutil.rmtree(beside, ignore_errors=True)
    beside.mkdir()
    try:
        yield beside
    finally:
        shutil.rmtree(beside, ignore_errors=True)


@contextmanager
def made_in_memory(path: Path) -> Iterator[io.BytesIO]:
    """Yield room in memory for a file, which is written at the end: for libraries that a full disk brings down.

    HDF5's ends Python with a segmentation fault where a file cannot be closed.
    """
    content = io.BytesIO()
    yield content
    # Written by the file itself: `write_bytes` takes a view of what it writes, which an error's frames would hold, and
    # a view that is there when Python 3.12 ends brings it down.
    with whole(path) as beside, beside.open("wb") as file:
        file.write(content.getbuffer())


def write_whole(path: Path, content: str | Iterable[str]) -> None:
    """Write a text file, given whole or in pieces."""
    with whole(path) as beside:
        _write(beside, content)


def _write(path: Path, content: str | Iterable[str]) -> None:
    with path.open("wb") as file:
        file.writelines(map(_encoded, (content,) if isinstance(content, str) else content))


def _encoded(text: str) -> bytes:
    r"""Return text as UTF-8, with names of files whose bytes Python could not read as letters.

    Where the system's own letters are ASCII alone, such names are UTF-8 as a rule; other bytes become ``\xe4``.
    """
    try:
        return text.encode()
    except UnicodeEncodeError:
        return text.encode(errors="surrogateescape").decode(errors="backslashreplace").encode()


@contextmanager
def writable(folder: Path | str) -> Iterator[None]:
    """Make a folder with its parents, and refuse it where that, or writing to it within the block, is not possible.

    Raises
    ------
    UnwritableError
        The folder cannot be written to.
    """
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        if not is_refusal_of(folder, error):
            raise
        raise refusal(Path(folder), error) from error


def refuse_unwritable(folder: Path | str) -> None:
    """Raise UnwritableError where a folder cannot be made or written to; nothing is made. For long work."""
    folder = Path(folder)
    try:
        place = next(p for p in (folder, *folder.absolute().parents) if p.exists())
    except OSError as error:  # as of a name that is too long
        raise refusal(folder, error) from error
    if not place.is_dir():
        raise refusal(folder, NotADirectoryError())
    if not os.access(place, os.W_OK):
        raise refusal(folder, PermissionError(0, "no permission"))


def placed(error: OSError, path: Path) -> OSError:
    """Return an error that names the file it is about, which that of a full disk does not."""
    if error.filename is None:
        error.filename = str(path)
    return error


def is_refusal_of(folder: Path | str, error: OSError) -> bool:
    """Whether an error says that a folder cannot be written to.

    It is about something in it, or about room, where no file is named.
    """
    if error.filename is None:
        return error.errno in NO_ROOM or NO_ROOM_WORDS in str(error)  # the latter as h5py has it
    place, whole_folder = Path(os.fsdecode(error.filename)).absolute(), Path(folder).absolute()
    return whole_folder == place or whole_folder in place.parents or place in whole_folder.parents


def _is_loose(place: Path) -> bool:
    return place.is_symlink() and not place.exists()


def refusal(folder: Path, error: OSError) -> UnwritableError:
    """Return the error that a folder cannot be written to, with the reason."""
    reasons: list[str] = []
    with suppress(OSError):  # as of a name that is too long
        places = (folder, *folder.parents)
        reasons = [f"{place} is a file" for place in places if place.is_file()]
        reasons += [f"{place} is a link that leads to nothing" for place in places if _is_loose(place)]
    why = reasons[0] if reasons else error.strerror or error
    remedy = "make room, or give another folder" if error.errno in NO_ROOM else "give another folder"
    return UnwritableError(f"{folder}: cannot be written to ({why}); {remedy}")


def write_together(folder: Path | str, texts: Mapping[str, str | Iterable[str]]) -> list[Path]:
    """Write texts, whole or in pieces, by file name; earlier ones are replaced, in this order, when all are whole.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    UnwritableError
        The folder cannot be written to.
    """
    files = {Path(folder) / name: text for name, text in texts.items()}
    with writable(folder), ExitStack() as renamed:
        for path, text in reversed(files.items()):  # what is entered last is renamed first
            _write(renamed.enter_context(whole(path)), text)
    return list(files)
