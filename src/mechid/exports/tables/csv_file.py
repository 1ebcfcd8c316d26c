"""CSV files of tables: one header line with names and units, and empty cells for missing numbers."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from mechid.arrays import FloatArray
from mechid.exports.tables.table import Cell, Table
from mechid.writing import write_atomically

NUMBER = "%.12g"


def write_csv(table: Table, folder: Path) -> str:
    """Write a table; return the file name."""
    name = f"{table.name}.csv"
    write_atomically(folder / name, _lines(table))
    return name


def read_csv(table: Table, folder: Path) -> dict[str, FloatArray]:
    """Read the numeric columns of a table from its file."""
    # The csv module handles line ends itself.
    with (folder / f"{table.name}.csv").open(encoding="utf-8", newline="") as file:
        rows = csv.DictReader(file)
        cells = [[row[name] for name in table.numeric] for row in rows]
    found = np.array([[float(cell or "nan") for cell in row] for row in cells], dtype=np.float64)
    return dict(zip(table.numeric, found.reshape(len(cells), len(table.numeric)).T, strict=True))


def _lines(table: Table) -> Iterator[str]:
    line = io.StringIO()
    writer = csv.writer(line, lineterminator="\n")
    heads: Iterable[tuple[Cell, ...]] = [tuple(column.name for column in table.columns)]
    for rows in (heads, table.rows()):
        for row in rows:
            writer.writerow([cell if isinstance(cell, str) else _number(cell) for cell in row])
            yield line.getvalue()
            # One buffer is reused for all rows, so that a long table is never held as text.
            line.seek(0)
            line.truncate()


def _number(value: float) -> str:
    """Format a number; NaN gives an empty string."""
    return "" if math.isnan(value) else NUMBER % value
