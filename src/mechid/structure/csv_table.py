"""Reader of small numeric CSV tables: one header line, ``#`` comments; commas, semicolons or tabs."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np

from mechid.arrays import FloatArray
from mechid.errors import InputFileError
from mechid.reading.whole import read_text

_UNIT = re.compile(r"\s*(?:\[([^\]]*)\]|\((.*)\))\s*$")


def read_numbers(path: Path) -> dict[str, FloatArray]:
    """Return the columns of a CSV file, (n,) each, by header.

    Raises
    ------
    InputFileError
        A cell is not a finite number, a line has the wrong number of cells, a header occurs twice, or there are no
        lines of numbers.
    """
    lines = [
        (k, text) for k, text in enumerate(_text(path).splitlines(), 1) if text.strip() and text.lstrip()[0] != "#"
    ]
    if len(lines) < 2:
        raise InputFileError(f"{path.name}: found {len(lines)} lines; write a header and at least one line of numbers")

    separator = max(",;\t", key=lines[0][1].count)
    header = _cells(lines[0][1], separator)
    for index, name in enumerate(header):
        if name in header[:index]:
            raise InputFileError(f'{path.name}: line {lines[0][0]}: column "{name}" occurs twice; keep one')
    rows = [_row(path.name, number, _cells(text, separator), header) for number, text in lines[1:]]
    return dict(zip(header, np.array(rows, dtype=np.float64).T.copy(), strict=True))


def split_unit(header: str) -> tuple[str, str | None]:
    """Split a header into its name and the unit in brackets, or None without a unit.

    Examples
    --------
    >>> split_unit("los_x_re [rad/(N*m)]"), split_unit("damping (%)")
    (('los_x_re', 'rad/(N*m)'), ('damping', '%'))
    """
    found = _UNIT.search(header)
    return (header[: found.start()], (found[1] or found[2] or "").strip()) if found else (header, None)


def _text(path: Path) -> str:
    try:
        return read_text(path)
    except UnicodeDecodeError as error:
        raise InputFileError(f"{path.name}: is not UTF-8 text; save the file as UTF-8") from error


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]


def _row(label: str, number: int, cells: list[str], header: list[str]) -> list[float]:
    if len(cells) != len(header):
        raise InputFileError(
            f"{label}: line {number}: found {len(cells)} cells, but the header has {len(header)}; write one per column"
        )
    row = []
    for name, cell in zip(header, cells, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise InputFileError(f'{label}: line {number}: column "{name}": found "{cell}"; write a finite number')
        row.append(value)
    return row
