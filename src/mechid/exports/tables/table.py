"""Table of named columns, the common content of all exported files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from mechid.arrays import FloatArray

Cell: TypeAlias = float | str

SHEET_ROWS = 1_048_576
"""Most rows of an Excel sheet, including the header."""


@dataclass(frozen=True, eq=False)
class Column:
    """Column of a table.

    Parameters
    ----------
    name : str
        Name with the unit at its end, as ``amplitude_Nm``.
    unit : str
        Unit in readable form, as ``N m``; empty for text, ``1`` for dimensionless numbers.
    words : str
        Meaning of the values.
    values : (n,) or tuple of n str
        Numbers, with NaN for missing ones; or text.
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
        Name of its file, sheet or group.
    columns : tuple of Column
    is_long : bool
        Whether the table is too long for a sheet of a workbook, as a time history.
    """

    name: str
    columns: tuple[Column, ...]
    is_long: bool = False

    def column(self, name: str) -> Column:
        """Return the column with this name."""
        return next(column for column in self.columns if column.name == name)

    @property
    def numeric(self) -> dict[str, FloatArray]:
        """The numeric columns by name."""
        return {column.name: column.values for column in self.columns if not isinstance(column.values, tuple)}

    @property
    def size(self) -> int:
        """Number of rows."""
        return len(self.columns[0].values)

    @property
    def fits_sheet(self) -> bool:
        """Whether the table fits on a sheet of a workbook."""
        return not self.is_long and self.size < SHEET_ROWS

    def rows(self) -> Iterator[tuple[Cell, ...]]:
        """Yield the rows."""
        values = (c.values if isinstance(c.values, tuple) else c.values.tolist() for c in self.columns)
        yield from zip(*values, strict=True)


def numbers(name: str, unit: str, words: str, values: object) -> Column:
    """Make a numeric column; None and values that are not finite become NaN."""
    found = np.asarray(values, dtype=np.float64)
    return Column(name, unit, words, np.where(np.isfinite(found), found, np.nan))


def texts(name: str, words: str, values: Iterator[str] | list[str]) -> Column:
    """Make a text column."""
    return Column(name, "", words, tuple(values))


def column_table(tables: tuple[Table, ...]) -> Table:
    """Return the table that describes all columns of the other tables."""
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
