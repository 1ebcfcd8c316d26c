"""Small tables of numbers as CSV: one header line, ``#`` comments; commas, semicolons or tabs."""

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
    """Return the columns of a CSV file by header, each (n,).

    Raises
    ------
    InputFileError
        A cell is no finite number, a line has another count of cells, a header stands twice, or no line follows it.
    """
    lines = [
        (k, text) for k, text in enumerate(_text(path).splitlines(), 1) if text.strip() and text.lstrip()[0] != "#"
    ]
    if len(lines) < 2:
        raise InputFileError(f"{path.name}: found {len(lines)} lines; write a header and a line of numbers at least")
    separator = max(",;\t", key=lines[0][1].count)
    header = _cells(lines[0][1], separator)
    for index, name in enumerate(header):
        if name in header[:index]:
            raise InputFileError(f'{path.name}: line {lines[0][0]}: column "{name}" stands here twice; keep one')
    rows = [_row(path.name, number, _cells(text, separator), header) for number, text in lines[1:]]
    return dict(zip(header, np.array(rows, dtype=np.float64).T.copy(), strict=True))


def split_unit(header: str) -> tuple[str, str | None]:
    """Split a header into its name and the unit in brackets, None where there is none.

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
        raise InputFileError(f"{label}: line {number}: {len(cells)} cells where the header has {len(header)}")
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
