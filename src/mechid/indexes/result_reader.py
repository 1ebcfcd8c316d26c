"""Reader of result files, which also detects damaged ones."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mechid.campaign.toml_file import read_toml
from mechid.errors import InputFileError
from mechid.indexes.kinds import Kind
from mechid.indexes.verdicts import Verdict
from mechid.ink.document import BAD
from mechid.reading.whole import is_file, read_result

DAMAGE = (KeyError, TypeError, ValueError, AttributeError, IndexError, RecursionError)
"""Errors raised in reading damaged numbers."""
FORMAT, OURS = "format", "mechid-"


@dataclass(frozen=True)
class FoundResult:
    """A result found below the folder.

    Attributes
    ----------
    kind : Kind
    file : Path
    content : mapping
        Numbers of the result; empty if it is damaged.
    verdict : Verdict
    is_damaged : bool
    """

    kind: Kind
    file: Path
    content: Mapping[str, Any]
    verdict: Verdict
    is_damaged: bool = False

    @property
    def folder(self) -> Path:
        """Folder of the result."""
        return self.file.parent


def found_in(file: Path, kind: Kind) -> FoundResult | None:
    """Read the result of a file, damaged or not; None if the file belongs to another program."""
    try:
        content = _content(file, kind)
    except InputFileError as error:
        return _damaged_result(file, kind, str(error).removeprefix(f"{file.name}: "))
    except OSError as error:
        return _damaged_result(file, kind, error.strerror or str(error))
    except DAMAGE as error:
        return _damaged_result(file, kind, f"cannot be read ({_words(error)})")
    # Other programs may write files of these names; mechid's have a format, or a page beside them.
    if kind.format and FORMAT not in content and not is_file(file.parent / kind.page):
        return None
    found = str(content.get(FORMAT, "nothing"))
    if kind.format and found != kind.format:
        return _damaged_result(file, kind, f'format: found {found}; this mechid reads "{kind.format}"')
    try:
        return FoundResult(kind, file, content, kind.verdict(content))
    except DAMAGE as error:
        return _damaged_result(file, kind, f"damaged at {_words(error)}")


def _content(file: Path, kind: Kind) -> Mapping[str, Any]:
    content = json.loads(read_result(file)) if kind.format else read_toml(file)
    if not isinstance(content, Mapping):
        raise TypeError(f"found {type(content).__name__}, no table")
    return content


def _damaged_result(file: Path, kind: Kind, why: str) -> FoundResult:
    return FoundResult(kind, file, {}, Verdict(f"{file.name}: {why}", BAD), is_damaged=True)


def _words(error: BaseException) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__
