"""Excel workbook of tables, one sheet per table, with a reader independent of the writing library."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree import ElementTree
from zipfile import ZipFile

import numpy as np
import xlsxwriter

from mechid.arrays import FloatArray
from mechid.exports.tables.table import Table
from mechid.writing import atomic_file

FILE_NAME = "tables.xlsx"
NARROWEST, WIDEST = 10, 60
"""Limits of the column width in characters."""
# Text must not be interpreted as formula or link; rows are written one by one to save memory.
PLAIN = {"constant_memory": True, "strings_to_formulas": False, "strings_to_urls": False}
SPACE = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"


def write_workbook(tables: Sequence[Table], folder: Path, name: str = FILE_NAME) -> str:
    """Write tables as sheets, in order; return the file name. Missing numbers are empty cells."""
    with atomic_file(folder / name) as beside, xlsxwriter.Workbook(str(beside), PLAIN) as book:
        head = book.add_format({"bold": True, "bottom": 1})
        for table in tables:
            sheet = book.add_worksheet(table.name)
            sheet.freeze_panes(1, 0)
            sheet.autofilter(0, 0, table.size, len(table.columns) - 1)
            for at, column in enumerate(table.columns):
                texts = column.values if isinstance(column.values, tuple) else ()
                longest = max(map(len, (column.name, *texts)))
                sheet.set_column(at, at, min(max(longest + 2, NARROWEST), WIDEST))
            sheet.write_row(0, 0, [column.name for column in table.columns], head)
            for number, row in enumerate(table.rows(), 1):
                for at, cell in enumerate(row):
                    if isinstance(cell, str) or not math.isnan(cell):
                        sheet.write(number, at, cell)
    return name


def read_workbook(tables: Sequence[Table], folder: Path) -> Iterator[dict[str, FloatArray]]:
    """Yield the numeric columns of each table, as read from the workbook."""
    with ZipFile(folder / FILE_NAME) as archive:
        for number, table in enumerate(tables, 1):
            with archive.open(f"xl/worksheets/sheet{number}.xml") as file:
                root = ElementTree.parse(file).getroot()
            names = [column.name for column in table.columns]
            found = {name: np.full(table.size, np.nan) for name in table.numeric}
            for cell in root.iter(f"{SPACE}c"):
                row, column = _place(cell.attrib["r"])
                value = cell.find(f"{SPACE}v")
                # In SpreadsheetML a cell without a type is a number.
                if row > 0 and value is not None and cell.get("t", "n") == "n" and value.text:
                    found[names[column]][row - 1] = float(value.text)
            yield found


def _place(reference: str) -> tuple[int, int]:
    """Return row and column of a cell reference, counted from 0.

    Examples
    --------
    >>> _place("AB3")
    (2, 27)
    """
    letters, digits = re.fullmatch(r"([A-Z]+)(\d+)", reference).groups()  # type: ignore[union-attr]
    column = 0
    for letter in letters:
        # Letters are digits from 1 to 26, without a zero.
        column = 26 * column + ord(letter) - ord("A") + 1
    return int(digits) - 1, column - 1
