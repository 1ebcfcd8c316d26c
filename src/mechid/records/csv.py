"""Reader of text files: CSV with commas, semicolons, tabs or white space.

NumPy's parser reads the file directly into one array whose fields are the columns. It is fast, needs no other memory,
and counts the cells of every row. After an error the lines are read again to find the cell that caused it.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import TypeAlias

import numpy as np

from mechid.arrays import FloatArray
from mechid.errors import RecordError
from mechid.records.csv_dialect import Dialect, from_utf8, sniff, split_cells
from mechid.records.csv_numbers import (
    NUMBER,
    REMEDY,
    Examples,
    Notation,
    has_unusual_marks,
    may_be_grouped,
    notation_of,
    note_kinds,
)
from mechid.records.memory import refuse_insufficient_disk
from mechid.records.table import ALL, Column, Metadata, column_label

Rows: TypeAlias = np.ndarray[tuple[int], np.dtype[np.void]]
Notations: TypeAlias = Mapping[int, Notation]
"""Notation of the numbers of columns, by index."""
CELL_BYTES = 20
"""Bytes of a long cell, including its separator, used to estimate the number of samples from the file size."""
WHOLE_BYTES = 1 << 26
"""Maximum size of a file that is parsed at once."""
AT_ONCE = 1 << 17
"""Number of lines of a larger file that are parsed together."""
LOCAL_SEPARATORS = (";", "\t")
"""Separators with which numbers may contain grouping points or commas without quotes."""
PIECE_CHARACTERS = 1 << 18
"""Number of characters searched together."""
TAIL_BYTES = 1 << 15
"""Number of bytes at the end of a file with which its last line is compared."""
CLOCK_TIME = re.compile(r"\d:\d\d|\d{4}-\d\d-\d\d|\d\d?[./]\d\d?[./]\d{2,4}")
"""Times and dates such as 10:00:01.5, 2026-11-25T10:00:01 or 25.11.2026."""
SPARE_DECIMALS = 3
"""Normal variation of the number of decimals if numbers are written in the shortest form."""


@dataclass(frozen=True)
class CsvTable:
    """Opened text file; its header has been read, its samples are read on demand."""

    path: Path
    label: str
    dialect: Dialect

    is_ordered = True
    is_sliced = True

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns from left to right."""
        return self.dialect.columns

    @property
    def metadata(self) -> Metadata:
        """Lines before the header."""
        return {f"line {number}": line for number, line in self.dialect.preamble}

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warning about a truncated last line: it has no line end, and its last cell is shorter than others."""
        with self.path.open("rb") as file:
            file.seek(-min(TAIL_BYTES, self.path.stat().st_size), 2)
            tail = file.read().replace(b"\0", b"").decode("latin-1")
        if tail.endswith(("\n", "\r")):
            return ()
        cells = [self.dialect.cells(line)[-1].lstrip("+-") for line in tail.split("\n")[1:] if line.strip()]
        if len(cells) < 2 or not _is_written_shorter(cells[-1].lower(), [cell.lower() for cell in cells[:-1]]):
            return ()
        return (f'{self.label}: the last line has no line end and stops at "{cells[-1]}": is the file cut off there?',)

    def read(self, wanted: Sequence[int], rows: slice = ALL) -> list[FloatArray]:
        """Return `rows` of the `wanted` columns as strided views; the whole file is read."""
        notations = self._cell_notations(wanted)
        # Faults are rare: the lines are searched for the faulty cell only after the parser has failed.
        try:
            parsed = self._parse(wanted, notations)
        except ValueError as error:
            raise self._find_fault(wanted, notations) or self.error(str(error)[:120]) from None
        found = [parsed[f"c{index}"] for index in wanted]
        if any(may_be_grouped(values, whole=self.dialect.separator in LOCAL_SEPARATORS) for values in found):
            self._notations(wanted)
        return [values[rows] for values in found]

    def blocks(self, wanted: Sequence[int], rows: slice = ALL) -> Iterator[list[FloatArray]]:
        """Yield the same block by block; a small file is a single block."""
        if self.path.stat().st_size <= WHOLE_BYTES:
            yield self.read(wanted, rows)
            return
        start, stop, _ = rows.indices(sys.maxsize)
        first = 0
        doubtful = [True] * len(wanted)
        for parsed in self._parse_blocks(wanted):
            found = [parsed[f"c{index}"] for index in wanted]
            doubtful = [
                doubt and may_be_grouped(values, whole=self.dialect.separator in LOCAL_SEPARATORS)
                for doubt, values in zip(doubtful, found, strict=True)
            ]
            inside = slice(max(start - first, 0), max(stop - first, 0))
            yield [values[inside] for values in found]
            first += parsed.size
            if first >= stop:
                return
        # Only all blocks together show whether a column may consist of grouped numbers.
        if any(doubtful):
            self._notations(wanted)

    def error(self, message: str, row: int | None = None) -> RecordError:
        """Return an error with the file, the line of sample `row`, and `message`."""
        place = "" if row is None else f" line {next(islice(self._lines(), row, None))[0]}:"
        return RecordError(f"{self.label}:{place} {message}")

    def _cell_notations(self, wanted: Sequence[int]) -> Notations | None:
        """Return the notations of columns if cells must be rewritten one by one for NumPy; otherwise None."""
        if not self._has_unusual_marks:
            return None
        notations = self._notations(wanted)
        by_cell = any(n.group or (n.decimal == "," and not self.dialect.decimal_comma) for n in notations.values())
        return notations if by_cell else None

    @cached_property
    def _has_unusual_marks(self) -> bool:
        """Whether the samples contain marks that plain numbers of this dialect do not have."""
        with self.path.open(encoding=self.dialect.encoding) as file:
            for _ in range(self.dialect.head_lines):
                file.readline()
            pieces = iter(lambda: file.read(PIECE_CHARACTERS), "")
            return has_unusual_marks(pieces, self.dialect.separator, decimal_comma=self.dialect.decimal_comma)

    @cached_property
    def _examples(self) -> tuple[Examples, ...]:
        """Examples of the kinds of numbers in each column."""
        examples: tuple[Examples, ...] = tuple({} for _ in self.columns)
        for number, line in self._lines():
            note_kinds(examples, number, split_cells(line, self.dialect.separator))
        return examples

    def _notations(self, wanted: Sequence[int]) -> Notations:
        """Return the notations of the numbers of columns.

        Raises
        ------
        RecordError
            A notation is ambiguous.
        """
        found = {}
        for index in wanted:
            notation = notation_of(self._examples, index, self.dialect.separator)
            if isinstance(notation, str):
                raise self.error(f"{column_label(self.columns, index)}: {notation}")
            found[index] = notation
        return found

    def _parse(self, wanted: Sequence[int], notations: Notations | None) -> Rows:
        """Return all rows."""
        if notations is None and not self.dialect.decimal_comma:
            return self._load_rows(self.path, wanted, self.dialect.separator, self.dialect.head_lines)
        with self.path.open(encoding=self.dialect.encoding) as file:
            return self._parse_lines(islice(file, self.dialect.head_lines, None), wanted, notations)

    def _parse_blocks(self, wanted: Sequence[int]) -> Iterator[Rows]:
        """Yield all rows in blocks of `AT_ONCE` lines."""
        notations = self._cell_notations(wanted)
        with self.path.open(encoding=self.dialect.encoding) as file:
            rest = islice(file, self.dialect.head_lines, None)
            while lines := list(islice(rest, AT_ONCE)):
                if all(map(self.dialect.is_blank, lines)):
                    continue
                try:
                    yield self._parse_lines(lines, wanted, notations)
                except ValueError as error:
                    raise self._find_fault(wanted, notations) or self.error(str(error)[:120]) from None

    def _parse_lines(self, lines: Iterable[str], wanted: Sequence[int], notations: Notations | None) -> Rows:
        """Return the rows of lines of the file."""
        if notations is not None:
            rows = (self._cells(line, notations) for line in lines if not self.dialect.is_blank(line))
            return self._load_rows(map("\t".join, rows), wanted, "\t", 0)
        if self.dialect.decimal_comma:
            lines = (line.replace(",", ".") for line in lines)
        return self._load_rows(lines, wanted, self.dialect.separator, 0)

    def _cells(self, line: str, notations: Notations | None) -> list[str]:
        """Return a line's cells in a form that NumPy can parse."""
        if notations is None:
            return self.dialect.cells(line)
        cells = split_cells(line, self.dialect.separator)
        return [notations[k].plain(cell) if k in notations else "-" for k, cell in enumerate(cells)]

    def _load_rows(
        self, lines: Path | Iterable[str], wanted: Sequence[int], separator: str | None, head_lines: int
    ) -> Rows:
        """Return the parsed rows of lines."""
        # Columns that are not wanted become single characters: they need no memory and their text cannot fail to parse.
        fields = [(f"c{i}", "f8" if i in wanted else "U1") for i in range(len(self.columns))]
        return np.loadtxt(
            lines,
            dtype=np.dtype(fields),
            encoding=self.dialect.encoding,
            delimiter=separator,
            skiprows=head_lines,
            comments=None,
            quotechar='"',
            ndmin=1,
        )

    def _lines(self) -> Iterator[tuple[int, str]]:
        """Yield the lines of the samples with their numbers from 1."""
        with self.path.open(encoding=self.dialect.encoding) as file:
            for number, line in enumerate(file, 1):
                if number > self.dialect.head_lines and not self.dialect.is_blank(line):
                    yield number, line

    def _find_fault(self, wanted: Sequence[int], notations: Notations | None) -> RecordError | None:
        """Return the error of the first line that is not a row of numbers, or None."""
        for number, line in self._lines():
            problem = self._problem(self._cells(line, notations), wanted)
            if problem:
                return RecordError(f"{self.label}: line {number}: {problem}")
        return None

    def _problem(self, cells: Sequence[str], wanted: Sequence[int]) -> str | None:
        if len(cells) != len(self.columns):
            return f"found {len(cells)} cells, but the file has {len(self.columns)} columns"
        for index in wanted:
            if not _is_parsable(cells[index]):
                return f"{column_label(self.columns, index)}: {self._describe_bad_cell(cells[index])}"
        return None

    def _describe_bad_cell(self, cell: str) -> str:
        """Return a description of a cell that is not a number, with a remedy if one is known."""
        if not cell:
            return "the cell is empty"
        text = from_utf8(cell) if self.dialect.encoding == "latin-1" else cell
        said = f'"{text.strip()[:40]}" is not a number'
        if CLOCK_TIME.search(text):
            return f"{said} but a time of day; export the seconds since the first sample instead"
        if NUMBER.fullmatch(text.strip()):
            return f'"{text.strip()[:40]}" is written with grouped digits; {REMEDY}'
        if not text.isascii():
            return f'{said} in plain letters; export the file with the digits 0 to 9, ".", "-" and no other signs'
        return said


def open_csv(path: Path, label: str) -> CsvTable:
    """Read the header of the text file at `path`; `label` is its name in messages."""
    size = path.stat().st_size
    if size > WHOLE_BYTES:
        refuse_insufficient_disk(lambda message: RecordError(f"{label}: {message}"), size // CELL_BYTES, 1)
    return CsvTable(path, label, sniff(path, label))


def _is_written_shorter(cell: str, others: Sequence[str]) -> bool:
    """Return whether a number may be truncated, compared with others of its column.

    This is the case if no other number is the same, and it is the shortest one; or its exponent is missing or shorter
    than all others; or it has fewer decimals than usual; or it is an integer with fewer digits than another.
    """
    if cell in others:
        return False
    exponents = [other.partition("e")[2] for other in others if "e" in other]
    usual = sorted(map(_decimals, others))[len(others) // 2]
    return (
        len(cell) < min(map(len, others))
        or (bool(exponents) and len(cell.partition("e")[2]) < min(map(len, exponents)))
        or _decimals(cell) < usual - SPARE_DECIMALS * (usual > SPARE_DECIMALS)
        or (usual == 0 and len(cell) < max(map(len, others)))
    )


def _decimals(cell: str) -> int:
    return len(cell.partition("e")[0].partition(".")[2])


def _is_parsable(cell: str) -> bool:
    """Return whether NumPy's parser accepts the cell as a number."""
    # Python's float also accepts underscores and non-ASCII digits, which NumPy's parser does not.
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell and cell.isascii()
