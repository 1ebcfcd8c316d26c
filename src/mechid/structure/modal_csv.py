"""Reader of modal tables in CSV format: ``frequency_Hz,damping,interface,<line of sight>,...``, one line per mode.

Columns named as `directions` in the budget contain the interface's motion along these directions.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from mechid.arrays import FloatArray
from mechid.errors import InputFileError, did_you_mean
from mechid.structure.csv_table import read_numbers, split_unit
from mechid.structure.damping import ASKED_ABOVE, damping_ratio, key_of_column
from mechid.structure.frequency import FREQUENCY, as_hertz
from mechid.structure.modes import Modes
from mechid.structure.selection import ROTATIONS, Selection
from mechid.structure.structure import Structure
from mechid.units import conversion_factor

DAMPING, INTERFACE = "damping", "interface"
SHAPE_UNIT, TRANSLATION_UNIT = "rad/(kg^0.5*m)", "1/kg^0.5"
NAME_COLUMN = 'name the column "damping [%]" if percent is meant, "damping [1]" if the share of critical is'
_NON_SHAPE_COLUMNS: Mapping[str, re.Pattern[str]] = {
    "numbers the modes; leave it out": re.compile(r"(mode )?(no|nr|num|number|index|id|#)\.?|mode|mode_?shape"),
    "is a modal mass, and shapes here are mass-normalised; divide them by its square root and leave it out": re.compile(
        r"(modal|generali[sz]ed) (mass|inertia)"
    ),
    "is no shape; leave it out": re.compile(
        r"(modal|generali[sz]ed) stiffness|effective (mass|inertia)|participation( factor)?|eigenvalue|period( s)?"
        r"|omega( rad s)?|(angular|circular|natural) frequency( hz| rad s)?|freq( hz)?"
    ),
}
"""Remedies by patterns of column names that modal tables contain besides shapes; they are not lines of sight."""


def read_modal_csv(path: Path, selection: Selection) -> Structure:
    """Read a modal table with mass-normalised shapes; units other than SI are stated in brackets.

    Raises
    ------
    InputFileError
        A column is missing, its unit has the wrong dimension, or its numbers are invalid.
    """
    columns = _columns(path, selection)
    for needed in (FREQUENCY, INTERFACE):
        if needed not in columns:
            near = did_you_mean(needed, columns)
            raise InputFileError(f'{path.name}: no column "{needed}"{near}; the header is frequency_Hz,damping,...')
    damping = columns.get(DAMPING)
    if damping is None:
        damping = selected_damping(selection, path.name, columns[FREQUENCY].size)
    for direction, name in selection.directions.items():
        if name not in columns or name in (FREQUENCY, DAMPING, INTERFACE):
            near = did_you_mean(name, columns)
            raise InputFileError(f'{path.name}: directions: {direction}: no column "{name}" of a direction{near}')
    taken = (FREQUENCY, DAMPING, INTERFACE, *selection.directions.values())
    names = tuple(name for name in columns if name not in taken)
    if not names:
        raise InputFileError(f'{path.name}: no line of sight; write a column for each, as "los_x"')
    shapes = np.array([columns[name] for name in names])
    modes = Modes(columns[FREQUENCY], damping, columns[INTERFACE], shapes)
    along = {direction: replace(modes, interface=columns[name]) for direction, name in selection.directions.items()}
    return Structure(name=path.name, line_of_sight=names, model=modes, directions=along)


def selected_damping(selection: Selection, label: str, modes: int) -> FloatArray:
    """Return the selection's damping for each mode, (modes,); raise InputFileError if it has none."""
    if selection.damping is None:
        raise InputFileError(f"{label}: contains no damping; give it, as damping = 0.005")
    return np.full(modes, selection.damping)


def _columns(path: Path, selection: Selection) -> dict[str, FloatArray]:
    """Return the columns in SI units by name; raise InputFileError for duplicates and columns that are not shapes."""
    moving = {name for direction, name in selection.directions.items() if direction not in ROTATIONS}
    columns: dict[str, FloatArray] = {}
    for header, data in read_numbers(path).items():
        named = split_unit(header)[0]
        if named not in selection.directions.values():
            _refuse_non_shape(named, path.name)
        name, values = _convert_column(header, data, path.name, moving)
        if name in columns:
            raise InputFileError(f'{path.name}: column "{header}": holds {name}, as does another column; remove one')
        columns[name] = values
    return columns


def _refuse_non_shape(name: str, label: str) -> None:
    plain = " ".join(re.split(r"[\s_]+", name.strip().lower()))
    for why, names in _NON_SHAPE_COLUMNS.items():
        if names.fullmatch(plain):
            raise InputFileError(f'{label}: column "{name}": {why}, or name it otherwise if it is a line of sight')


def _convert_column(header: str, data: FloatArray, label: str, moving: Collection[str]) -> tuple[str, FloatArray]:
    """Return a column's name and its values in SI units; `moving` are the names of translations."""
    name, unit = split_unit(header)
    hertz = as_hertz(name, unit, data, label)
    if hertz is not None:
        return FREQUENCY, hertz
    if damping := key_of_column(name, unit, label):
        # With a stated unit large values are unambiguous.
        asked_above = math.inf if damping[1] else ASKED_ABOVE
        place = f'{label}: column "{header}"'
        return DAMPING, damping_ratio(data, damping[0], place, asked_above=asked_above, remedy=NAME_COLUMN)
    if unit is None:
        return name, data
    expected = TRANSLATION_UNIT if name in moving else SHAPE_UNIT
    factor = conversion_factor(unit, expected)
    if factor is None:
        raise InputFileError(f'{label}: column "{header}": unit "{unit}" is not valid here; expected {expected}')
    return name, factor * data
