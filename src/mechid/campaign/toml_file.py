"""Reader of TOML files with messages that name the line and a remedy, and writer of single TOML values."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mechid.errors import InputFileError, did_you_mean
from mechid.plant.tables import TABLES
from mechid.reading.whole import is_folder, read_bytes

_WHERE = re.compile(r"\s*\(at line (\d+), column (\d+)\)$")
KINDS = {
    "mechanism": {"assembly", *(name.partition(".")[0] for name in TABLES)},
    "campaign": {"mechanism", "record", "stage"},
    "budget": {"estimate", "requirement"},
    "fleet": {"campaign", "before_after", "false_discovery_rate"},
}
"""Top-level keys that identify the kind of a file."""
SHARED = {"requirement"}
"""Keys that files of several kinds have, so that they tell no other kind: campaigns and budgets have requirements."""
_QUOTED = {'"': '\\"', "\\": "\\\\"}


def read_toml(path: Path, kind: str = "") -> dict[str, Any]:
    """Read a TOML file.

    Parameters
    ----------
    path : Path
    kind : str
        Required kind, one of `KINDS`; empty for any.

    Raises
    ------
    InputFileError
        The file is missing, not text, not TOML (with line and column if known), or of another kind.
    """
    content = _content(path)
    try:
        table = tomllib.loads(content)
    except tomllib.TOMLDecodeError as error:
        raise InputFileError(f"{path.name}: {_syntax(str(error), content)}") from error
    # TOML allows NUL through an escape, but file names do not.
    if any("\0" in each for each in _texts(table)):
        raise InputFileError(f"{path.name}: a text holds the character NUL, which no name can have; leave it out")
    # A shared key proves no kind: a campaign with requirements is no budget either.
    if kind and not (KINDS[kind] - SHARED) & table.keys():
        other = next((name for name, keys in KINDS.items() if (keys - SHARED) & table.keys()), "")
        if other:
            raise InputFileError(f"{path.name}: is a {other} file; give a {kind} file")
    return table


def _texts(entry: Any) -> Iterator[str]:
    """Yield every key and string of a table, including nested tables and lists."""
    if isinstance(entry, str):
        yield entry
    elif isinstance(entry, dict | list):
        for each in entry:
            yield from _texts(each)
        for value in entry.values() if isinstance(entry, dict) else ():
            yield from _texts(value)


def toml_text(value: str) -> str:
    """Return a string in TOML notation, in double quotes."""
    return '"' + "".join(map(_escape, value)) + '"'


def toml_number(value: float) -> str:
    """Return a float in TOML notation, with all digits."""
    return repr(float(value))


def _escape(character: str) -> str:
    if character in _QUOTED:
        return _QUOTED[character]
    return f"\\u{ord(character):04X}" if ord(character) < 0x20 or ord(character) == 0x7F else character


def _content(path: Path) -> str:
    try:
        # Editors on Windows put a byte order mark in front, which TOML does not allow.
        return read_bytes(path).decode("utf-8-sig")
    except FileNotFoundError as error:
        beside = [other.name for other in path.parent.iterdir()] if is_folder(path.parent) else []
        near = did_you_mean(path.name, beside) or "; check the path"
        # Following the link fails like a missing file, so the message tells the difference.
        near = "; it is a broken link" if path.is_symlink() else near
        raise InputFileError(f"{path}: there is no such file{near}") from error
    except OSError as error:
        reason = "it is a folder" if is_folder(path) else error.strerror
        raise InputFileError(f"{path}: cannot be read ({reason}); check the path") from error
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise InputFileError(f"{path.name}: line {line}: is not UTF-8 text; save the file as UTF-8") from error


def _syntax(message: str, content: str) -> str:
    """Rewrite a parser message: the place first, then the problem, the line and a remedy."""
    lines = content.splitlines()
    at = _WHERE.search(message)
    row, column = (int(at[1]), f", column {at[2]}") if at else (len(lines), "")
    problem = _WHERE.sub("", message).removesuffix(" (at end of document)")
    line = lines[row - 1].strip()[:60] if 0 < row <= len(lines) else ""
    return f"line {row}{column}: {problem[:1].lower()}{problem[1:]}, in '{line}'; {_remedy(line, problem)}"


def _remedy(line: str, problem: str) -> str:
    if "twice" in problem or "overwrite" in problem:
        return "the name is there already: keep one, or write [[...]] before each where there may be several"
    if line.count("{") > line.count("}"):
        return "a table in { } has to stand on one line"
    if "\\" in line:
        return 'write paths with /, as "data/run.csv"'
    return "write name = value, a number without unit and a text in double quotes"
