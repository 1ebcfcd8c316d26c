"""How a text file of numbers is written: encoding, separator, decimal sign, header."""

from __future__ import annotations

import codecs
import csv
import re
from dataclasses import dataclass
from itertools import islice, pairwise
from pathlib import Path

from mechid.errors import RecordError
from mechid.records.csv_numbers import is_number
from mechid.records.table import Column
from mechid.units import is_unit

BYTE_ORDER_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
SEPARATORS = (";", "\t", ",")
"""Looked for in this order: beside the first two a comma is a decimal sign."""
UNUSED = "comment"
"""A last column of a header that no row has: so LabVIEW's text files end."""
MOST_HEAD_LINES = 200
"""So many lines an instrument may write before the samples."""
LONGEST_LINE = 1 << 20
"""Letters of a line that are looked at: what is no text may have no line end at all."""
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
    columns : tuple of Column
        Named by the header, without names where the file has none; with units where a line of its own
        states them.
    head_lines : int
        Lines before the first sample, blank ones included.
    preamble : tuple of (int, str)
        What an instrument writes before the header, with line numbers from 1.
    """

    encoding: str
    separator: str | None
    decimal_comma: bool
    columns: tuple[Column, ...]
    head_lines: int
    preamble: tuple[tuple[int, str], ...] = ()

    def cells(self, line: str) -> list[str]:
        """Return a data line's cells as the numbers are to be parsed."""
        return split_cells(line.replace(",", ".") if self.decimal_comma else line, self.separator)

    def is_blank(self, line: str) -> bool:
        """Whether NumPy's parser passes over the line."""
        return not (line.strip() if self.separator is None else line.strip("\r\n"))


def sniff(path: Path, label: str) -> Dialect:
    """Find out how the file at `path` is written.

    The header is the line before the first sample, or the second before where a line of units stands
    between.

    Raises
    ------
    RecordError
        It is empty, no text, has a header only, or header and samples differ in columns.
    """
    encoding = _encoding(path)
    lines = _first_lines(path, label, encoding)
    place = _first_sample(lines)
    (number, row), before = lines[place], lines[:place]
    separator = _separator(row, before[-1][1] if before else row)
    decimal_comma = separator in (";", "\t") and _has_comma(path)
    cells = split_cells(row, separator)
    if place == 0 and not all(map(is_number, cells)):
        raise RecordError(f"{label}: line {number}: a header, but no samples after it")
    units, before = _units(before, separator, encoding, len(cells))
    headers = _headers(before[-1][1], separator, encoding) if before else ("",) * len(cells)
    if len(headers) == len(cells) + 1 and headers[-1].strip().lower() == UNUSED:
        headers = headers[:-1]
    _refuse_other_width(label, headers, cells)
    return Dialect(
        encoding=encoding,
        separator=separator,
        decimal_comma=decimal_comma,
        columns=tuple(Column(name=name, unit=unit) for name, unit in zip(headers, units, strict=True)),
        head_lines=number - 1,
        preamble=tuple((line_number, line.strip()) for line_number, line in before[:-1]),
    )


def _first_sample(lines: list[tuple[int, str]]) -> int:
    """Return the place of the first sample among the first lines that are not blank.

    It is the first line that begins with a number; where none does, the first of two with a number in some
    cell and as many cells.
    """
    numbers = [list(map(is_number, split_cells(line, _separator(line, line)))) for _, line in lines]
    for place, found in enumerate(numbers):
        if found[:1] == [True]:
            return place
    for place, (found, following) in enumerate(pairwise(numbers)):
        if any(found) and any(following) and len(found) == len(following):
            return place
    return min(1, len(lines) - 1)


def _units(
    before: list[tuple[int, str]], separator: str | None, encoding: str, columns: int
) -> tuple[tuple[str | None, ...], list[tuple[int, str]]]:
    """Return the units that the last line before the samples states for all columns, and the lines before it."""
    if len(before) > 1:
        cells = [cell.strip().strip("[]()") for cell in _headers(before[-1][1], separator, encoding)]
        stated = [cell for cell in cells if cell not in ("", "-")]
        if len(cells) == columns and stated and all(map(is_unit, stated)):
            return tuple(cell if cell in stated else None for cell in cells), before[:-1]
    return (None,) * columns, before


def split_cells(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line without their quotes and the white space around them."""
    if separator is None:
        return [cell.strip('"') for cell in line.split()]
    if '"' not in line:
        return [cell.strip() for cell in line.split(separator)]
    whole = " ".join(line.splitlines())  # a lone carriage return within a line ends it for the csv module
    return [cell.strip() for cell in next(csv.reader([whole], delimiter=separator), [""])]


def _encoding(path: Path) -> str:
    with path.open("rb") as file:
        head = file.read(4)
    return next((name for mark, name in BYTE_ORDER_MARKS.items() if head.startswith(mark)), "latin-1")


def _first_lines(path: Path, label: str, encoding: str) -> list[tuple[int, str]]:
    """Return the first lines that are not blank, with their numbers."""
    with path.open(encoding=encoding) as file:
        numbered = enumerate(iter(lambda: file.readline(LONGEST_LINE), ""), 1)
        lines = list(islice(((n, line) for n, line in numbered if line.strip()), MOST_HEAD_LINES))
    if not lines:
        raise RecordError(f"{label}: the file is empty")
    if any("\0" in line for _, line in lines):
        raise RecordError(f"{label}: not a text file; export it as csv")
    return lines


def _separator(row: str, header: str) -> str | None:
    return next((mark for line in (row, header) for mark in SEPARATORS if mark in line), None)


def _has_comma(path: Path) -> bool:
    with path.open("rb") as file:
        return any(b"," in chunk for chunk in iter(lambda: file.read(1 << 20), b""))


def _headers(line: str, separator: str | None, encoding: str) -> tuple[str, ...]:
    """Return the header's cells; without a separator a unit in brackets stays with its name."""
    if encoding == "latin-1":
        line = from_utf8(line)
    if separator is None:
        return tuple(_OUTSIDE_BRACKETS.split(line.strip()))
    return tuple(split_cells(line, separator))


def from_utf8(line: str) -> str:
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
