"""Modal table as CSV: ``frequency_Hz,damping,interface,<line of sight>,...``, a line for each mode.

Columns that the budget names as `directions` are the interface's motion along these.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

import numpy as np

from mechid.arrays import FloatArray
from mechid.errors import InputFileError, did_you_mean
from mechid.structure.csv_table import read_numbers, split_unit
from mechid.structure.modes import Modes
from mechid.structure.selection import ROTATIONS, Selection
from mechid.structure.structure import Structure
from mechid.units import conversion_factor

FREQUENCY, DAMPING, INTERFACE = "frequency_Hz", "damping", "interface"
SHAPE_UNIT, TRANSLATION_UNIT = "rad/(kg^0.5*m)", "1/kg^0.5"


def read_modal_csv(path: Path, selection: Selection) -> Structure:
    """Return the structure of a modal table; shapes are mass-normalised, other units stand in brackets.

    Raises
    ------
    InputFileError
        A column is missing, its unit measures something else, or its numbers are wrong.
    """
    moving = {name for direction, name in selection.directions.items() if direction not in ROTATIONS}
    columns = dict(_converted(name, data, path.name, moving) for name, data in read_numbers(path).items())
    for needed in (FREQUENCY, INTERFACE):
        if needed not in columns:
            near = did_you_mean(needed, columns)
            raise InputFileError(f'{path.name}: no column "{needed}"{near}; the header is frequency_Hz,damping,...')
    damping = columns.get(DAMPING)
    if damping is None:
        damping = given_damping(selection, path.name, columns[FREQUENCY].size)
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


def given_damping(selection: Selection, label: str, modes: int) -> FloatArray:
    """Return the selection's damping for each mode, (modes,); InputFileError where there is none."""
    if selection.damping is None:
        raise InputFileError(f"{label}: holds no damping; give it, as damping = 0.005")
    return np.full(modes, selection.damping)


def _converted(header: str, data: FloatArray, label: str, moving: Collection[str]) -> tuple[str, FloatArray]:
    """Return a column in SI; `moving` are those of translations."""
    name, unit = split_unit(header)
    if unit is None:
        return name, data
    expected = {FREQUENCY: "Hz", "frequency": "Hz", DAMPING: "1"}.get(
        name, TRANSLATION_UNIT if name in moving else SHAPE_UNIT
    )
    factor = conversion_factor(unit, expected)
    if factor is None:
        raise InputFileError(f'{label}: column "{header}": unit "{unit}" is none for it; expected {expected}')
    return FREQUENCY if name == "frequency" else name, factor * data
