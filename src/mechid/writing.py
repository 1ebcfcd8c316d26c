"""Atomic writing of files, and the errors for folders that cannot be written to."""

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
"""Environment variable that names another folder for compiled kernels and for samples of long records."""
NO_ROOM = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
NO_ROOM_WORDS = os.strerror(errno.ENOSPC)
_READ: ContextVar[set[Path] | None] = ContextVar("read", default=None)
"""The user's files read so far by the running command; None outside a command."""


def cache_folder() -> Path:
    """Return mechid's cache folder: the one in the environment variable `CACHE`, else the user's cache."""
    named = os.environ.get(CACHE)
    return Path(named) if named else Path(platformdirs.user_cache_dir("mechid"))


@contextmanager
def protect_read_files() -> Iterator[None]:
    """Within the block, protect the files passed to `mark_as_read` against being overwritten by a result."""
    reset = _READ.set(set())
    try:
        yield
    finally:
        _READ.reset(reset)


def mark_as_read(path: Path) -> None:
    """Register a file that the user's command reads, so that no result of that command replaces it."""
    read = _READ.get()
    if read is not None:
        read.add(path.resolve())


def refuse_input_file(path: Path) -> None:
    """Raise UsageError if the file to be written was read by the same command."""
    if path.resolve() in (_READ.get() or ()):
        raise UsageError(f"{path}: is one of the files that were read, and is not replaced; give another folder")


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path next to `path`; rename it to `path` at the end, or remove it on failure.

    Raises
    ------
    UsageError
        The same command has read the file at `path`.
    """
    refuse_input_file(path)
    # In the same folder: a rename is atomic only within one file system. The process id keeps two runs apart.
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield beside
        beside.replace(path)
    except OSError as error:
        raise attach_path(error, path) from None
    finally:
        beside.unlink(missing_ok=True)


@contextmanager
def staging_folder(folder: Path, name: str) -> Iterator[Path]:
    """Yield an empty temporary folder within another, for files moved once all are complete; remove it after."""
    beside = folder / f".{name}.{os.getpid()}.part"
    shutil.rmtree(beside, ignore_errors=True)
    beside.mkdir()
    try:
        yield beside
    finally:
        shutil.rmtree(beside, ignore_errors=True)


@contextmanager
def buffered_file(path: Path) -> Iterator[io.BytesIO]:
    """Yield a memory buffer whose content is written to `path` at the end, for libraries that cannot bear a full disk.

    HDF5, for one, ends Python with a segmentation fault if it cannot close a file.
    """
    content = io.BytesIO()
    yield content
    # Written through the file object: `write_bytes` takes a memoryview of the buffer, which the frames of an error
    # would keep alive, and a memoryview alive at exit crashes Python 3.12.
    with atomic_file(path) as beside, beside.open("wb") as file:
        file.write(content.getbuffer())


def write_atomically(path: Path, content: str | Iterable[str]) -> None:
    """Write a text file atomically, from one string or from pieces."""
    with atomic_file(path) as beside:
        _write(beside, content)


def _write(path: Path, content: str | Iterable[str]) -> None:
    with path.open("wb") as file:
        file.writelines(map(_encode, (content,) if isinstance(content, str) else content))


def _encode(text: str) -> bytes:
    r"""Encode text as UTF-8, including file names whose bytes Python could not decode.

    Where the locale is plain ASCII, such names are UTF-8 as a rule; other bytes become ``\xe4``.
    """
    try:
        return text.encode()
    except UnicodeEncodeError:
        return text.encode(errors="surrogateescape").decode(errors="backslashreplace").encode()


@contextmanager
def creating_folder(folder: Path | str) -> Iterator[None]:
    """Create a folder with its parents; turn its errors, and those of the block in it, into UnwritableError.

    Raises
    ------
    UnwritableError
        The folder cannot be written to.
    """
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        if not is_unwritable_error(folder, error):
            raise
        raise unwritable_error(Path(folder), error) from error


def refuse_unwritable(folder: Path | str) -> None:
    """Raise UnwritableError if a folder cannot be created or written to; create nothing. For use before long work."""
    folder = Path(folder)
    try:
        place = next(p for p in (folder, *folder.absolute().parents) if p.exists())
    except OSError as error:  # as of a name that is too long
        raise unwritable_error(folder, error) from error
    if not place.is_dir():
        raise unwritable_error(folder, NotADirectoryError())
    if not os.access(place, os.W_OK):
        raise unwritable_error(folder, PermissionError(0, "no permission"))


def attach_path(error: OSError, path: Path) -> OSError:
    """Return the error with the path set; the system's error about a full disk names no file."""
    if error.filename is None:
        error.filename = str(path)
    return error


def is_unwritable_error(folder: Path | str, error: OSError) -> bool:
    """Return whether an error says that a folder cannot be written to.

    Such an error names a path in or above the folder, or names no path and reports a lack of space.
    """
    if error.filename is None:
        return error.errno in NO_ROOM or NO_ROOM_WORDS in str(error)  # the latter as h5py has it
    place, whole_folder = Path(os.fsdecode(error.filename)).absolute(), Path(folder).absolute()
    return whole_folder == place or whole_folder in place.parents or place in whole_folder.parents


def _is_dangling_link(place: Path) -> bool:
    return place.is_symlink() and not place.exists()


def unwritable_error(folder: Path, error: OSError) -> UnwritableError:
    """Return the error that a folder cannot be written to, with the reason and the remedy."""
    reasons: list[str] = []
    with suppress(OSError):  # as of a name that is too long
        places = (folder, *folder.parents)
        reasons = [f"{place} is a file" for place in places if place.is_file()]
        reasons += [f"{place} is a broken link" for place in places if _is_dangling_link(place)]
    why = reasons[0] if reasons else error.strerror or error
    remedy = "make room, or give another folder" if error.errno in NO_ROOM else "give another folder"
    return UnwritableError(f"{folder}: cannot be written to ({why}); {remedy}")


def write_together(folder: Path | str, texts: Mapping[str, str | Iterable[str]]) -> list[Path]:
    """Write texts by file name, whole or in pieces; earlier files are replaced in this order once all are complete.

    Returns
    -------
    list of Path
        Paths of the files.

    Raises
    ------
    UnwritableError
        The folder cannot be written to.
    """
    files = {Path(folder) / name: text for name, text in texts.items()}
    with creating_folder(folder), ExitStack() as renamed:
        # An exit stack unwinds backwards: the file entered last is renamed first.
        for path, text in reversed(files.items()):
            _write(renamed.enter_context(atomic_file(path)), text)
    return list(files)
