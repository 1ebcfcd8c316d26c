"""Modal table as CSV: ``frequency_Hz,damping,interface,<line of sight>,...``, a line for each mode."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mechid.errors import InputFileError, did_you_mean
from mechid.structure.modes import Modes
from mechid.structure.numbers_file import read_numbers, split_unit
from mechid.structure.selection import Selection
from mechid.structure.structure import Structure
from mechid.units import conversion_factor

FREQUENCY, DAMPING, INTERFACE = "frequency_Hz", "damping", "interface"
SHAPE_UNIT = "rad/(kg^0.5*m)"


def read_modal_csv(path: Path, selection: Selection) -> Structure:
    """Return the structure of a modal table; shapes are mass-normalised, other units stand in brackets.

    Raises
    ------
    InputFileError
        A column is missing, its unit measures something else, or its numbers are wrong.
    """
    columns = dict(_converted(name, data, path.name) for name, data in read_numbers(path).items())
    for needed in (FREQUENCY, INTERFACE):
        if needed not in columns:
            near = did_you_mean(needed, columns)
            raise InputFileError(f'{path.name}: no column "{needed}"{near}; the header is frequency_Hz,damping,...')
    damping = columns.get(DAMPING)
    if damping is None:
        damping = given_damping(selection, path.name, columns[FREQUENCY].size)
    names = tuple(name for name in columns if name not in (FREQUENCY, DAMPING, INTERFACE))
    if not names:
        raise InputFileError(f'{path.name}: no line of sight; write a column for each, as "los_x"')
    shapes = np.array([columns[name] for name in names])
    modes = Modes(columns[FREQUENCY], damping, columns[INTERFACE], shapes)
    return Structure(name=path.name, line_of_sight=names, model=modes)


def given_damping(selection: Selection, label: str, modes: int) -> NDArray[np.float64]:
    """Return the selection's damping for each mode, (modes,); InputFileError where there is none."""
    if selection.damping is None:
        raise InputFileError(f"{label}: holds no damping; give it, as damping = 0.005")
    return np.full(modes, selection.damping)


def _converted(header: str, data: NDArray[np.float64], label: str) -> tuple[str, NDArray[np.float64]]:
    name, unit = split_unit(header)
    if unit is None:
        return name, data
    expected = {FREQUENCY: "Hz", "frequency": "Hz", DAMPING: "1"}.get(name, SHAPE_UNIT)
    factor = conversion_factor(unit, expected)
    if factor is None:
        raise InputFileError(f'{label}: column "{header}": unit "{unit}" is none for it; expected {expected}')
    return FREQUENCY if name == "frequency" else name, factor * data
