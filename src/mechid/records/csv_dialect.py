"""Detection of the dialect of a numeric text file: encoding, separator, decimal sign, header."""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice, pairwise
from pathlib import Path

from mechid.errors import RecordError
from mechid.records.csv_numbers import is_number
from mechid.records.csv_units import (
    COMMENT,
    Splitter,
    StatedUnit,
    bare_unit,
    doubts_of_name,
    is_comment,
    is_line_of_units,
    stated_units,
    states_units_of,
)
from mechid.records.table import Column

BYTE_ORDER_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
SEPARATORS = (";", "\t", ",")
"""Separators in the order of the search; with the first two, a comma is a decimal sign."""
UNUSED_HEADER = "comment"
"""Last column of the header in LabVIEW's text files, which no row contains."""
MAX_HEAD_LINES = 200
"""Maximum number of lines before the samples."""
LONGEST_LINE = 1 << 20
"""Maximum number of characters of a line that are read; a binary file may have no line end at all."""
_OUTSIDE_BRACKETS = re.compile(r"\s+(?![\[(]|[^\[(]*[\])])")


@dataclass(frozen=True, kw_only=True)
class Dialect:
    """Dialect of a text file.

    Parameters
    ----------
    encoding : str
        According to the byte order mark, or else Latin-1, in which digits are the same as in UTF-8.
    separator : str or None
        None for any white space.
    decimal_comma : bool
        Whether numbers have a decimal comma.
    columns : tuple of Column
        Columns with names from the header, if there is one, and units from a separate line, if there is one.
    head_lines : int
        Number of lines before the first sample, including blank ones.
    preamble : tuple of (int, str)
        Lines before the samples other than the header, with line numbers from 1.
    """

    encoding: str
    separator: str | None
    decimal_comma: bool
    columns: tuple[Column, ...]
    head_lines: int
    preamble: tuple[tuple[int, str], ...] = ()

    def cells(self, line: str) -> list[str]:
        """Return the cells of a data line, ready for parsing."""
        return split_cells(line.replace(",", ".") if self.decimal_comma else line, self.separator)

    def is_blank(self, line: str) -> bool:
        """Return whether NumPy's parser skips the line."""
        return not (line.strip() if self.separator is None else line.strip("\r\n"))


def sniff(path: Path, label: str) -> Dialect:
    """Detect the dialect of the file at `path`.

    The header is the last line before the first sample that is neither a line of units nor a comment on another line.

    Raises
    ------
    RecordError
        The file is empty, is not text, has a header only, or header and samples differ in their number of columns.
    """
    encoding = _detect_encoding(path)
    lines = _first_lines(path, label, encoding)
    place = _first_sample(lines)
    (number, row), before = lines[place], lines[:place]
    separator = _detect_separator(row, before[-1][1] if before else row)
    # The whole file is searched, because the first samples may be integers without a decimal sign.
    decimal_comma = separator in (";", "\t") and _has_comma(path)
    cells = split_cells(row, separator)
    if place == 0 and not all(map(is_number, cells)):
        raise RecordError(f"{label}: line {number}: a header, but no samples after it")
    split = partial(_headers, separator=separator)
    before = [(at, from_utf8(line) if encoding == "latin-1" else line) for at, line in before]
    place = _find_header([line for _, line in before], split, len(cells))
    headers = _strip_comment(split(before[place][1])) if before else ("",) * len(cells)
    _refuse_other_width(label, headers, cells)
    others = [line for k, line in enumerate(before) if k != place]
    stated = stated_units(headers, others, split, before[place][0] if before else 0)
    return Dialect(
        encoding=encoding,
        separator=separator,
        decimal_comma=decimal_comma,
        columns=_columns(headers, stated),
        head_lines=number - 1,
        preamble=tuple((at, line.strip()) for at, line in others),
    )


def _columns(names: Sequence[str], stated: Sequence[StatedUnit]) -> tuple[Column, ...]:
    """Return the columns; the header may consist of units only, and a name that ends in ``in ms`` is ambiguous."""
    if any(names) and is_line_of_units(names):
        return tuple(Column(name=name, unit=bare_unit(name)) for name in names)
    return tuple(
        Column(name=name, unit=one.unit, unit_doubts=doubts_of_name(name) | one.doubts)
        for name, one in zip(names, stated, strict=True)
    )


def _find_header(before: Sequence[str], split: Splitter, columns: int) -> int:
    """Return the index of the header: the last line before the samples that is neither units nor a comment.

    A comment is the header if there is no line of the same width above that it refers to.
    """
    units = len(before) - 1
    for place in reversed(range(len(before))):
        cells = _strip_comment(split(before[place]))
        is_wide = len(cells) == columns
        if is_wide and is_line_of_units(cells, whole=False):
            units = place
        elif is_comment(before[place]):
            wide = [line for line in map(split, before[:place]) if len(line) == columns]
            if is_wide and not (wide and states_units_of(wide[-1], before[place])):
                return place
        else:
            return place if is_wide else units
    return units


def _strip_comment(cells: Sequence[str]) -> tuple[str, ...]:
    """Return the names of columns without a leading comment mark and without LabVIEW's unused last column."""
    first = COMMENT.sub("", cells[0], count=1) or cells[0]
    last = len(cells) - (len(cells) > 1 and cells[-1].strip().lower() == UNUSED_HEADER)
    return (first, *cells[1:last])


def _first_sample(lines: list[tuple[int, str]]) -> int:
    """Return the index of the first sample among the first lines that are not blank.

    It is the first line that begins with a number, or else the first of two lines that contain numbers and have the
    same number of cells.
    """
    numbers = [list(map(is_number, split_cells(line, _detect_separator(line, line)))) for _, line in lines]
    for place, found in enumerate(numbers):
        if found[:1] == [True]:
            return place
    for place, (found, following) in enumerate(pairwise(numbers)):
        if any(found) and any(following) and len(found) == len(following):
            return place
    return min(1, len(lines) - 1)


def split_cells(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line without quotes and surrounding white space."""
    if separator is None:
        return [cell.strip('"') for cell in line.split()]
    if '"' not in line:
        return [cell.strip() for cell in line.split(separator)]
    # The csv module treats a lone carriage return as a line end.
    whole = " ".join(line.splitlines())
    return [cell.strip() for cell in next(csv.reader([whole], delimiter=separator), [""])]


def _detect_encoding(path: Path) -> str:
    with path.open("rb") as file:
        head = file.read(4)
    return next((name for mark, name in BYTE_ORDER_MARKS.items() if head.startswith(mark)), "latin-1")


def _first_lines(path: Path, label: str, encoding: str) -> list[tuple[int, str]]:
    """Return the first lines that are not blank, with their line numbers."""
    with path.open(encoding=encoding) as file:
        numbered = enumerate(iter(lambda: file.readline(LONGEST_LINE), ""), 1)
        lines = list(islice(((n, line) for n, line in numbered if line.strip()), MAX_HEAD_LINES))
    if not lines:
        raise RecordError(f"{label}: the file is empty")
    if any("\0" in line for _, line in lines):
        raise RecordError(f"{label}: not a text file; export it as csv")
    return lines


def _detect_separator(row: str, header: str) -> str | None:
    return next((mark for line in (row, header) for mark in SEPARATORS if mark in line), None)


def _has_comma(path: Path) -> bool:
    with path.open("rb") as file:
        return any(b"," in chunk for chunk in iter(lambda: file.read(1 << 20), b""))


def _headers(line: str, separator: str | None) -> tuple[str, ...]:
    """Return the header's cells; in a header separated by white space, a unit in brackets remains with its name."""
    if separator is None:
        return tuple(_OUTSIDE_BRACKETS.split(line.strip()))
    return tuple(split_cells(line, separator))


def from_utf8(line: str) -> str:
    """Return a line that was read as Latin-1, decoded as UTF-8 if possible."""
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
