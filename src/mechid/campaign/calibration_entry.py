"""``calibration`` entry of ``[bench]``: a 6 x 6 matrix from the campaign file or a CSV file, with its units."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign.place import (
    Place,
    describe_entry,
    non_negative_number,
    number,
    refuse_unknown_keys,
    required_entry,
    text,
)
from mechid.command.entry import is_table
from mechid.reading.whole import read_text
from mechid.records.calibration import Calibration
from mechid.records.components import COMPONENTS
from mechid.units import conversion_factor

KEYS = ("matrix", "file", "input_unit", "output_unit", "uncertainty_percent")
PAIR_REMEDY = 'write {key} = ["N", "N*m"], the units of forces and of moments'
INPUT_REMEDY = 'write input_unit = "V" where the channels are voltages, input_unit = ["N", "N*m"] where they are loads'
UNCERTAINTY_REMEDY = "write the standard error that the certificate states, as uncertainty_percent = 0.5"
ROWS_REMEDY = "write six rows of six numbers, one row for each load: fx, fy, fz, mx, my, mz"
SIX = len(COMPONENTS)
SINGULAR = 1e-6
"""Smallest singular value over the largest, of the matrix with rows and columns of equal size, of a singular one."""
_ROUNDS = 20


def reads_volts(table: Mapping[str, Any], key: str = "bench") -> bool:
    """Tell whether a campaign file's ``[bench]`` has a calibration of voltages; the entry may be invalid otherwise."""
    entry = table.get(key)
    calibration = entry.get("calibration") if isinstance(entry, Mapping) else None
    unit = calibration.get("input_unit") if isinstance(calibration, Mapping) else None
    return isinstance(unit, str) and conversion_factor(unit, "V") is not None


def read_calibration(entry: Any, place: Place, folder: Path) -> Calibration:
    """Return the calibration of the table, in SI units.

    Parameters
    ----------
    entry : object
    place : Place
    folder : Path
        Against which the file's path is taken.

    Raises
    ------
    InputFileError
        Units are missing, the matrix is not 6 x 6 or is singular, or the file cannot be read.
    """
    if not is_table(entry):
        raise place.error(
            f'{describe_entry(entry)}; write a table, as {{ file = "calibration.csv", input_unit = "V", '
            'output_unit = ["N", "N*m"], uncertainty_percent = 0.5 }'
        )
    refuse_unknown_keys(entry, KEYS, place)
    given = required_entry(entry, "input_unit", place, INPUT_REMEDY)
    in_volts = isinstance(given, str)
    per = _per_volt(given, place.key("input_unit")) if in_volts else read_units(entry, "input_unit", place)
    matrix, source = _matrix(entry, place, folder)
    scaled = read_units(entry, "output_unit", place)[:, None] * matrix / per[None, :]
    _refuse_singular(scaled, place.key(source[0]), source[1])
    percent = required_entry(entry, "uncertainty_percent", place, UNCERTAINTY_REMEDY)
    return Calibration(
        matrix=scaled,
        in_volts=in_volts,
        uncertainty=0.01 * non_negative_number(percent, place.key("uncertainty_percent"), "%"),
        source=source[1],
        file=folder / source[1] if source[0] == "file" else None,
    )


def read_units(entry: Mapping[str, Any], key: str, place: Place) -> FloatArray:
    """Return the factors to N and N m, (6,), that the pair of units under a key makes.

    Raises
    ------
    InputFileError
        The units are missing, or not those of a force and of a moment.
    """
    remedy, at = PAIR_REMEDY.format(key=key), place.key(key)
    pair = required_entry(entry, key, place, remedy)
    if not isinstance(pair, list) or len(pair) != 2 or not all(isinstance(one, str) for one in pair):
        raise at.error(f"{describe_entry(pair)}; {remedy}")
    factors = [conversion_factor(unit, si) for unit, si in zip(pair, ("N", "N*m"), strict=True)]
    if factors[0] is None or factors[1] is None:
        which, what = (0, "force") if factors[0] is None else (1, "moment")
        raise at.item(which).error(f'"{pair[which]}" is no unit of a {what}; {remedy}')
    return np.repeat([factors[0], factors[1]], 3)


def _per_volt(unit: str, place: Place) -> FloatArray:
    factor = conversion_factor(unit, "V")
    if factor is None:
        raise place.error(f'"{unit}" is no unit of a voltage; {INPUT_REMEDY}')
    return np.full(SIX, factor)


def _matrix(entry: Mapping[str, Any], place: Place, folder: Path) -> tuple[FloatArray, tuple[str, str]]:
    """Return the matrix in its own units, and the key and the name of its source."""
    if ("matrix" in entry) == ("file" in entry):
        found = "found both matrix and file" if "matrix" in entry else "found neither matrix nor file"
        raise place.error(f'{found}; write one, as file = "calibration.csv", or matrix = [[...], ...]')
    if "matrix" in entry:
        return _rows(entry["matrix"], place.key("matrix")), ("matrix", "the matrix of campaign.toml")
    name = text(entry["file"], place.key("file"), 'write the name of the file, as file = "calibration.csv"')
    return _file_rows(folder / name, place.key("file")), ("file", name)


def _rows(entry: Any, place: Place) -> FloatArray:
    if not isinstance(entry, list) or len(entry) != SIX:
        found = f"found {len(entry)} rows" if isinstance(entry, list) else describe_entry(entry)
        raise place.error(f"{found}; {ROWS_REMEDY}")
    for k, row in enumerate(entry):
        if not isinstance(row, list) or len(row) != SIX:
            found = f"found {len(row)} numbers" if isinstance(row, list) else describe_entry(row)
            raise place.item(k).error(f"{found}; {ROWS_REMEDY}")
    return np.array([[number(v, place.item(k).item(j), "1") for j, v in enumerate(row)] for k, row in enumerate(entry)])


def _file_rows(path: Path, place: Place) -> FloatArray:
    """Return six lines of six numbers; lines that begin with a # and one header line are passed over."""
    try:
        lines = read_text(path).splitlines()
    except FileNotFoundError as error:
        raise place.error(f"{path.name}: there is no such file beside {place.file}; check the path") from error
    except UnicodeDecodeError as error:
        raise place.error(f"{path.name}: is not UTF-8 text; save it as CSV in UTF-8") from error
    except OSError as error:
        raise place.error(f"{path.name}: cannot be read ({error.strerror or error}); check the path") from error
    kept = [(k, line) for k, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")]
    delimiter = next((sign for sign in (";", "\t", ",") if kept and sign in kept[0][1]), None)
    cells = [(k, [cell.strip() for cell in line.split(delimiter)]) for k, line in kept]
    if cells and all(_value(cell) is None for cell in cells[0][1]):
        cells = cells[1:]
    if len(cells) != SIX:
        raise place.error(f"{path.name}: found {len(cells)} rows of numbers; {ROWS_REMEDY}")
    rows = []
    for k, row in cells:
        values = [_value(cell) for cell in row]
        if len(row) != SIX or None in values:
            found = f"found {len(row)} cells" if len(row) != SIX else f'found "{row[values.index(None)]}"'
            raise place.error(f"{path.name}: line {k}: {found}; {ROWS_REMEDY}")
        rows.append(values)
    return np.array(rows, dtype=np.float64)


def _value(cell: str) -> float | None:
    try:
        value = float(cell)
    except ValueError:
        return None
    return value if np.isfinite(value) else None


def _refuse_singular(matrix: FloatArray, place: Place, source: str) -> None:
    """Refuse a matrix that cannot tell the loads apart, whatever the units of its rows and columns."""
    scaled = matrix.copy()
    for _ in range(_ROUNDS):  # alternating makes rows and columns of equal size, which takes the units out
        for axis in (0, 1):
            size = np.linalg.norm(scaled, axis=axis, keepdims=True)
            if np.any(size == 0.0):
                which = COMPONENTS[int(np.flatnonzero(size.ravel() == 0.0)[0])]
                what = "column" if axis == 0 else "row"
                raise place.error(f"{source} is singular: the {what} of {which} is zero; give all six components")
            scaled = scaled / size
    left, size, _ = np.linalg.svd(scaled)
    if size[-1] < SINGULAR * size[0]:
        alike = [COMPONENTS[k] for k in np.flatnonzero(np.abs(left[:, -1]) > 0.1)]
        raise place.error(
            f"{source} is singular: its rows of {', '.join(alike)} depend on each other, so the loads cannot be told "
            "apart; check for a row that was copied twice"
        )
