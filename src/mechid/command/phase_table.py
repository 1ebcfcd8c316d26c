"""A driver's table of phase values: one row for each microstep of an electrical period.

A row holds the normalised voltages (currents, with a current drive) of both phases, fractions of the peak, from the
electrical angle 0 on, where the paper's driver has e_A = -1 and e_B = 0 (u_A = -U cos, u_B = U sin).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.command.entry import format_found, is_number
from mechid.command.rate_table import rows_of_table
from mechid.command.waveform import phase_voltages
from mechid.errors import InputFileError, UsageError

PhaseTable: TypeAlias = tuple[tuple[float, float], ...]
COLUMNS = ("microstep", "phase_a", "phase_b")
MOST = 1.5
"""Largest value: a table that shapes its peaks needs a few per cent above 1; percentages and codes are far above."""
SAME = 1e-12
"""Difference of two values that counts as rounding."""
ROWS_A_FULL_STEP = 4
"""Rows of a table for each microstep of a full step: an electrical period has four full steps."""


def nominal_table(microsteps: int) -> FloatArray:
    """Return the table of the cosine, (4 n, 2).

    Examples
    --------
    >>> nominal_table(1)
    array([[-1.,  0.],
           [ 0.,  1.],
           [ 1.,  0.],
           [ 0., -1.]])
    """
    return phase_voltages(np.arange(ROWS_A_FULL_STEP * microsteps), microsteps, 0.0, "cosine")


def table_of(found: Any, microsteps: int, folder: Path = Path()) -> PhaseTable:
    """Return the table that an entry gives: the name of a CSV file, or its rows.

    Raises
    ------
    UsageError
        The file cannot be read, or the rows are not 4 n pairs of numbers within `MOST`.
    """
    if isinstance(found, str):
        try:
            return checked_table(read_phase_table(folder / found), microsteps)
        except (InputFileError, UsageError) as error:
            text = str(error).removeprefix("table: ")
            where = "" if isinstance(error, InputFileError) else f"{folder / found}: "
            raise UsageError(f"table: {where}{text}") from error
    if not isinstance(found, Sequence) or not found:
        raise UsageError(f'table: found {format_found(found)}; write the name of a file, as "table.csv", or its rows')
    return checked_table(found, microsteps)


def checked_table(rows: Iterable[Any], microsteps: int) -> PhaseTable:
    """Return rows as a table; raise `UsageError` unless they are 4 n pairs of numbers within `MOST`."""
    made = list(rows)
    for at, row in enumerate(made):
        fair = isinstance(row, list | tuple) and len(row) == 2 and all(map(is_number, row))
        if not fair or max(map(abs, row)) > MOST:
            remedy = f"write [phase_a, phase_b], fractions of the peak within {MOST} of zero"
            raise UsageError(f"table: row {at}: found {format_found(row)}; {remedy}")
    if len(made) != ROWS_A_FULL_STEP * microsteps:
        need = f"{microsteps} microsteps a full step need {ROWS_A_FULL_STEP * microsteps}, an electrical period"
        raise UsageError(f"table: found {len(made)} rows; {need}")
    return tuple((float(a), float(b)) for a, b in made)


def read_phase_table(path: Path) -> list[list[float]]:
    """Return the rows of a CSV file with the columns ``microstep,phase_a,phase_b``, microsteps from 0 on.

    Raises
    ------
    InputFileError
        The file cannot be read, has another header, or a line that is none of three numbers in their order.
    """
    lines = rows_of_table(path)
    header = ",".join(COLUMNS)
    if not lines or tuple(lines[0][1]) != COLUMNS:
        found = format_found(",".join(lines[0][1])) if lines else "an empty file"
        remedy = f'write "{header}", the phases as fractions of the peak'
        raise InputFileError(f"{path}: header: found {found}; {remedy}")
    rows = []
    for at, (line, cells) in enumerate(lines[1:]):
        try:
            number, *values = (float(cell) for cell in cells)
        except ValueError:
            number, values = float("nan"), []
        if number != at or len(values) != 2:
            remedy = f"write {at}, then both phases: one line for each microstep, from 0 on"
            raise InputFileError(f"{path}: line {line}: found {format_found(','.join(cells))}; {remedy}")
        rows.append(values)
    return rows


def symmetry_deg(table: PhaseTable) -> float:
    """Return the smallest of 90, 180 and 360 deg by which the electrical angle may turn with the phases' roles.

    Over 90 deg the cosine's table has e_A' = e_B and e_B' = -e_A; over 180 deg both signs change.

    Examples
    --------
    >>> symmetry_deg(nominal_table(4))
    90.0
    """
    e = np.array(table)
    quarter = len(e) // ROWS_A_FULL_STEP
    if np.allclose(np.roll(e, -quarter, axis=0), np.stack((e[:, 1], -e[:, 0]), axis=1), rtol=0.0, atol=SAME):
        return 90.0
    return 180.0 if np.allclose(np.roll(e, -2 * quarter, axis=0), -e, rtol=0.0, atol=SAME) else 360.0


def phase_table_text(table: PhaseTable) -> str:
    """Return a table as the text of its CSV file."""
    lines = [f"{at},{a!r},{b!r}" for at, (a, b) in enumerate(table)]
    return "\n".join([",".join(COLUMNS), *lines]) + "\n"


def first_row(start_angle_deg: float, microsteps: int) -> int:
    """Return the row of a start angle; raise `UsageError` where the angle lies between two rows."""
    at = start_angle_deg * microsteps / 90.0
    if abs(at - round(at)) > 1e-9 * max(abs(at), 1.0):
        step = 90.0 / microsteps
        raise UsageError(f"start_angle_deg: found {start_angle_deg:g}; a table has values at multiples of {step:g} deg")
    return round(at)


def table_voltages(table: PhaseTable, index: IntArray, start_angle_deg: float, microsteps: int) -> FloatArray:
    """Return e_A and e_B of step indices, (E, 2), from a table; the first row is at the electrical angle 0."""
    rows = np.array(table)
    found: FloatArray = rows[(index + first_row(start_angle_deg, microsteps)) % len(rows)]
    return found
