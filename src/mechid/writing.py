"""Files that are there whole or as they were, and a folder that cannot be written to as the user's error."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

from mechid.errors import UsageError


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
    with whole(path) as beside, beside.open("w", encoding="utf-8", newline="\n") as file:
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
        why = error.strerror or error
        raise UsageError(f"{folder}: cannot be written to ({why}); give another folder") from error


def write_together(folder: Path | str, texts: Mapping[str, str]) -> list[Path]:
    """Write texts by file name into a folder; earlier ones are replaced, in this order, when all are whole.

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
            renamed.enter_context(whole(path)).write_text(text, encoding="utf-8", newline="\n")
    return list(files)
