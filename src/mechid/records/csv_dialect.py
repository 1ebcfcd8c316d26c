"""How a text file of numbers is written: encoding, separator, decimal sign, header."""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mechid.errors import RecordError

BYTE_ORDER_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
SEPARATORS = (";", "\t", ",")
"""Looked for in this order: beside the first two a comma is a decimal sign."""
_OUTSIDE_BRACKETS = re.compile(r"\s+(?![\[(]|[^\[(]*[\])])")


@dataclass(frozen=True, kw_only=True)
class Dialect:
    """How one file is written.

    Parameters
    ----------
    encoding : str
        By the byte order mark, else Latin-1, in which digits are the same as in UTF-8.
    separator : str or None
        None: any white space.
    decimal_comma : bool
        Whether numbers are written with a comma.
    columns : tuple of str
        Headers; empty texts where the file has none.
    head_lines : int
        Lines before the first sample, blank ones included.
    """

    encoding: str
    separator: str | None
    decimal_comma: bool
    columns: tuple[str, ...]
    head_lines: int

    def cells(self, line: str) -> list[str]:
        """Return a data line's cells as the numbers are to be parsed."""
        return split_cells(line.replace(",", ".") if self.decimal_comma else line, self.separator)

    def is_blank(self, line: str) -> bool:
        """Whether NumPy's parser passes over the line."""
        return not (line.strip() if self.separator is None else line.strip("\r\n"))


def sniff(path: Path, label: str) -> Dialect:
    """Find out how the file at `path` is written from its first two lines.

    Raises
    ------
    RecordError
        It is empty, no text, has a header only, or header and samples differ in columns.
    """
    encoding = _encoding(path)
    (first_number, first), second = _first_lines(path, label, encoding)
    separator = _separator(second or first, first)
    decimal_comma = separator in (";", "\t") and _has_comma(path)
    row = split_cells(second or first, separator)
    if all(_is_number(cell, decimal_comma) for cell in split_cells(first, separator)):
        columns, head_lines = ("",) * len(row), first_number - 1
    elif second is None:
        raise RecordError(f"{label}: line {first_number}: a header, but no samples after it")
    else:
        columns, head_lines = _headers(first, separator, encoding), first_number
        _refuse_other_width(label, columns, row)
    return Dialect(
        encoding=encoding,
        separator=separator,
        decimal_comma=decimal_comma,
        columns=columns,
        head_lines=head_lines,
    )


def split_cells(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line without their quotes and the white space around them."""
    if separator is None:
        return [cell.strip('"') for cell in line.split()]
    if '"' not in line:
        return [cell.strip() for cell in line.split(separator)]
    return [cell.strip() for cell in next(csv.reader([line.strip("\r\n")], delimiter=separator), [""])]


def _encoding(path: Path) -> str:
    with path.open("rb") as file:
        head = file.read(4)
    return next((name for mark, name in BYTE_ORDER_MARKS.items() if head.startswith(mark)), "latin-1")


def _first_lines(path: Path, label: str, encoding: str) -> tuple[tuple[int, str], str | None]:
    """Return the first line that is not blank, with its number, and the next one, None at the end."""
    with path.open(encoding=encoding) as file:
        lines: Iterator[tuple[int, str]] = ((n, line) for n, line in enumerate(file, 1) if line.strip())
        first = next(lines, None)
        second = next(lines, (0, None))[1]
    if first is None:
        raise RecordError(f"{label}: the file is empty")
    if "\0" in first[1]:
        raise RecordError(f"{label}: not a text file; export it as csv")
    return first, second


def _separator(row: str, header: str) -> str | None:
    return next((mark for line in (row, header) for mark in SEPARATORS if mark in line), None)


def _has_comma(path: Path) -> bool:
    with path.open("rb") as file:
        return any(b"," in chunk for chunk in iter(lambda: file.read(1 << 20), b""))


def _is_number(cell: str, decimal_comma: bool) -> bool:
    try:
        float(cell.replace(",", ".") if decimal_comma else cell)
    except ValueError:
        return False
    return True


def _headers(line: str, separator: str | None, encoding: str) -> tuple[str, ...]:
    """Return the header's cells; without a separator a unit in brackets stays with its name."""
    if encoding == "latin-1":
        line = _from_utf8(line)
    if separator is None:
        return tuple(_OUTSIDE_BRACKETS.split(line.strip()))
    return tuple(split_cells(line, separator))


def _from_utf8(line: str) -> str:
    """Return a line read as Latin-1 as the UTF-8 that it may be."""
    try:
        return line.encode("latin-1").decode("utf-8")
    except UnicodeDecodeError:
        return line


def _refuse_other_width(label: str, columns: tuple[str, ...], row: list[str]) -> None:
    if len(columns) != len(row):
        raise RecordError(
            f"{label}: {len(columns)} columns in the header and {len(row)} in the first sample; "
            "a decimal comma needs semicolons or tabs between columns"
        )
