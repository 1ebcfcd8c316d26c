"""A table of named columns, as every file of the export holds it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from mechid.arrays import FloatArray

Cell: TypeAlias = float | str

SHEET_ROWS = 1_048_576
"""Of a sheet of Excel, its header line among them."""


@dataclass(frozen=True, eq=False)
class Column:
    """Values under one name.

    Parameters
    ----------
    name : str
        With the unit at its end, as ``amplitude_Nm``.
    unit : str
        As a reader writes it, as ``N m``; empty of text, ``1`` of what has none.
    words : str
        What it holds.
    values : (n,) or tuple of n str
        Numbers, NaN where there is none; or text.
    """

    name: str
    unit: str
    words: str
    values: FloatArray | tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of one length.

    Parameters
    ----------
    name : str
        Of its file, sheet or group.
    columns : tuple of Column
    is_long : bool
        Whether it is too long for a sheet of a workbook, as a time history.
    """

    name: str
    columns: tuple[Column, ...]
    is_long: bool = False

    def column(self, name: str) -> Column:
        """Return the column of a name."""
        return next(column for column in self.columns if column.name == name)

    @property
    def numeric(self) -> dict[str, FloatArray]:
        """The columns of numbers by name."""
        return {column.name: column.values for column in self.columns if not isinstance(column.values, tuple)}

    @property
    def size(self) -> int:
        """Number of rows."""
        return len(self.columns[0].values)

    @property
    def fits_sheet(self) -> bool:
        """Whether a sheet of a workbook holds it."""
        return not self.is_long and self.size < SHEET_ROWS

    def rows(self) -> Iterator[tuple[Cell, ...]]:
        """Yield the rows."""
        values = (c.values if isinstance(c.values, tuple) else c.values.tolist() for c in self.columns)
        yield from zip(*values, strict=True)


def numbers(name: str, unit: str, words: str, values: object) -> Column:
    """Return a column of numbers; None and what is not finite become NaN."""
    found = np.asarray(values, dtype=np.float64)
    return Column(name, unit, words, np.where(np.isfinite(found), found, np.nan))


def texts(name: str, words: str, values: Iterator[str] | list[str]) -> Column:
    """Return a column of text."""
    return Column(name, "", words, tuple(values))


def column_table(tables: tuple[Table, ...]) -> Table:
    """Return the table that says what every column of the others holds."""
    every = [(table.name, column) for table in tables for column in table.columns]
    return Table(
        "columns",
        (
            texts("table", "table, sheet or group", [table for table, _ in every]),
            texts("column", "its name", [column.name for _, column in every]),
            texts("unit", "its unit", [column.unit for _, column in every]),
            texts("meaning", "what it holds", [column.words for _, column in every]),
        ),
    )
