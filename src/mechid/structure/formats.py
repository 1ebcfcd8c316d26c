"""Selection of the reader for a structure file by its format.

A new format needs a reader, a function from (path, selection) to a `Structure`, and its suffix in `READERS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from mechid.errors import InputFileError, did_you_mean
from mechid.reading.process import read_guarded
from mechid.reading.whole import is_folder, is_there, refuse_special
from mechid.structure.checks import LARGEST_RECEPTANCE, refuse_overflow
from mechid.structure.csv_table import read_numbers, split_unit
from mechid.structure.mat import read_mat
from mechid.structure.modal_csv import read_modal_csv
from mechid.structure.modal_toml import read_modal_toml
from mechid.structure.modes import Modes
from mechid.structure.nastran import read_craig_bampton, read_nas2cam
from mechid.structure.response_csv import PAIRS, read_response_csv
from mechid.structure.selection import Selection
from mechid.structure.structure import Structure
from mechid.structure.uff import read_uff
from mechid.writing import mark_as_read

Reader = Callable[[Path, Selection], Structure]


def read_csv(path: Path, selection: Selection) -> Structure:
    """Read a CSV file: a frequency response if column names end in ``_re``, ``_mag`` or the like, otherwise modes."""
    names = [split_unit(header)[0] for header in read_numbers(path)]
    pairs = any(name.endswith(end) for name in names for pair in PAIRS for end in pair)
    return read_response_csv(path, selection) if pairs else read_modal_csv(path, selection)


GUARDED: Mapping[str, Reader] = {
    ".uff": read_uff,
    ".unv": read_uff,
    ".mat": read_mat,
    ".op2": read_nas2cam,
    ".op4": read_craig_bampton,
}
"""Readers that run in the reading process (`mechid.reading`), isolated from crashes caused by damaged files."""
CHECKED_RANGE_HZ, CHECKED_POINTS = (1e-3, 1e5), 97
"""Frequency range and number of points of the overflow check."""
READERS: Mapping[str, Reader] = {".toml": read_modal_toml, ".csv": read_csv, **GUARDED}
"""Reader by suffix, in lower case."""


def read_structure(path: Path | str, selection: Selection | None = None, *, axis: str = "") -> Structure:
    """Read a structure from a file and check it.

    Parameters
    ----------
    path : Path
        The suffix determines the format.
    selection : Selection or None
        Degrees of freedom and units; not needed for files with named columns.
    axis : str
        Axis of the mechanism, ``"rx"``, ``"ry"`` or ``"rz"``; an error is raised if the file states a different one.

    Raises
    ------
    InputFileError
        The file is missing or invalid; a one-line message names the file, the finding and the remedy.
    """
    path = Path(path)
    if is_folder(path):
        raise InputFileError(f"{path}: is a folder; give the file of the structure")
    if not is_there(path):
        beside = [other.name for other in path.parent.iterdir()] if is_folder(path.parent) else []
        raise InputFileError(f"{path}: there is no such file{did_you_mean(path.name, beside) or '; check the path'}")
    if path.suffix.lower() not in READERS:
        raise InputFileError(f'{path.name}: no reader for "{path.suffix}"; mechid reads {", ".join(READERS)}')
    mark_as_read(path)
    structure = _read(path, selection or Selection())
    if axis and structure.axis and structure.axis != axis:
        raise InputFileError(
            f"{path.name}: describes a torque about {structure.axis} but the mechanism turns about {axis}"
        )
    _refuse_overflow(structure)
    return _with_axis(structure, axis) if structure.directions else structure


def load_structure(path: Path | str, *, axis: str = "") -> Structure:
    """Read a structure from a file with named columns; docs/budget.md describes the formats.

    Parameters
    ----------
    path : Path
    axis : str
        Axis of the mechanism, ``"rx"``, ``"ry"`` or ``"rz"``; an error is raised if the file states a different one.

    Raises
    ------
    InputFileError
        The file is missing or invalid; a one-line message names the file, the finding and the remedy.

    Examples
    --------
    >>> import mechid
    >>> mechid.load_structure("structure.toml").line_of_sight  # doctest: +SKIP
    ('x', 'y')
    """
    return read_structure(path, axis=axis)


def _refuse_overflow(structure: Structure) -> None:
    """Raise an error if responses of a structure overflow."""
    for direction, model in {structure.axis or "torque": structure.model, **structure.directions}.items():
        low, high = model.coverage_hz
        frequency_hz = np.geomspace(
            max(low, CHECKED_RANGE_HZ[0]), max(min(high, CHECKED_RANGE_HZ[1]), CHECKED_RANGE_HZ[0]), CHECKED_POINTS
        )
        with np.errstate(all="ignore"):
            size = np.abs(model.response(frequency_hz))
        # Modes are known at all positive frequencies, so NaN means an overflow; other models are NaN where not known.
        lost = size > LARGEST_RECEPTANCE if not isinstance(model, Modes) else ~(size <= LARGEST_RECEPTANCE)
        refuse_overflow(f"{structure.name}: {direction}", frequency_hz, lost)


def _with_axis(structure: Structure, axis: str) -> Structure:
    """Return a structure with several directions, after checking that the mechanism's axis is known."""
    axis = structure.axis or axis
    if not axis:
        raise InputFileError(f'{structure.name}: has several directions; say which is the mechanism\'s, axis = "rz"')
    if axis in structure.directions:
        raise InputFileError(
            f"{structure.name}: directions: {axis} is the mechanism's own, its interface; leave it out"
        )
    return replace(structure, axis=axis)


def _read(path: Path, selection: Selection) -> Structure:
    """Read a file, and prefix errors raised by the model with the file's name."""
    suffix = path.suffix.lower()
    try:
        refuse_special(path)
        # After this check no reader can block on a pipe or a device.
        if suffix in GUARDED:
            return read_guarded(GUARDED[suffix], path, selection, kind="of a structure")
        return READERS[suffix](path, selection)
    except OSError as error:
        raise InputFileError(f"{path.name}: cannot be read ({error.strerror or error}); check the path") from error
    except InputFileError as error:
        message = str(error)
        raise InputFileError(message if message.startswith(path.stem) else f"{path.name}: {message}") from error
