"""Files that are there whole or as they were, and a folder that cannot be written to as the user's error."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

import platformdirs

from mechid.errors import UsageError

CACHE = "MECHID_CACHE"
"""Variable of the environment that names another folder for kernels and for the samples of long records."""


def cache_folder() -> Path:
    """Return mechid's own folder for what is kept or set aside: the one that `CACHE` names, else the user's cache."""
    named = os.environ.get(CACHE)
    return Path(named) if named else Path(platformdirs.user_cache_dir("mechid"))


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Yield a place beside `path` to write to, which is renamed at the end; nothing of it stays where that fails."""
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield beside
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)


def write_whole(path: Path, content: str | Iterable[str]) -> None:
    """Write a text file, given whole or in pieces."""
    with whole(path) as beside:
        _write(beside, content)


def _write(path: Path, content: str | Iterable[str]) -> None:
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.writelines((content,) if isinstance(content, str) else content)


@contextmanager
def writable(folder: Path | str) -> Iterator[None]:
    """Make a folder with its parents, and refuse it where that, or writing within the block, is not possible.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        raise _refusal(Path(folder), error) from error


def refuse_unwritable(folder: Path | str) -> None:
    """Raise UsageError where a folder cannot be made or written to; nothing is made. For what takes long before it."""
    folder = Path(folder)
    place = next(p for p in (folder, *folder.absolute().parents) if p.exists())
    if not place.is_dir():
        raise _refusal(folder, NotADirectoryError())
    if not os.access(place, os.W_OK):
        raise _refusal(folder, PermissionError(0, "no permission"))


def _refusal(folder: Path, error: OSError) -> UsageError:
    """Return the error that a folder cannot be written to, with the reason."""
    files = [place for place in (folder, *folder.parents) if place.is_file()]
    why = f"{files[0]} is a file" if files else error.strerror or error
    return UsageError(f"{folder}: cannot be written to ({why}); give another folder")


def write_together(folder: Path | str, texts: Mapping[str, str | Iterable[str]]) -> list[Path]:
    """Write texts, whole or in pieces, by file name; earlier ones are replaced, in this order, when all are whole.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    files = {Path(folder) / name: text for name, text in texts.items()}
    with writable(folder), ExitStack() as renamed:
        for path, text in reversed(files.items()):  # what is entered last is renamed first
            _write(renamed.enter_context(whole(path)), text)
    return list(files)
