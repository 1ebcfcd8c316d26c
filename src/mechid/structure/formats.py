"""From a file to a structure: the one place that knows which reader reads which format.

A further format is one reader, a function from (path, selection) to a `Structure`, and its suffix in `READERS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from mechid.errors import InputFileError, did_you_mean
from mechid.reading.process import UnreadableError, call
from mechid.reading.whole import is_folder, is_there, refuse_special
from mechid.structure.checks import LARGEST, refuse_no_numbers
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
    """Return the structure of a CSV file: a frequency response where columns end in ``_re`` or ``_mag``, else modes."""
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
"""Readers that run in the process that reads (`mechid.reading`), where a damaged file can do no harm."""
LOOKED_AT_HZ, POINTS = (1e-3, 1e5), 97
"""Where a structure is looked at for numbers that are none."""
READERS: Mapping[str, Reader] = {".toml": read_modal_toml, ".csv": read_csv, **GUARDED}
"""Reader by suffix, in lower case."""


def read_structure(path: Path | str, selection: Selection | None = None, *, axis: str = "") -> Structure:
    """Return the structure that a file describes, checked.

    Parameters
    ----------
    path : Path
        Its suffix tells the format.
    selection : Selection or None
        Which degrees of freedom, in which units; files whose columns have names need none.
    axis : str
        Axis of the mechanism, ``"rx"``, ``"ry"`` or ``"rz"``; refused where the file says another.

    Raises
    ------
    InputFileError
        The file is missing or wrong; one line with file, what was found and remedy.
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
            f"{path.name}: is for a torque about {structure.axis} where the mechanism turns about {axis}"
        )
    _refuse_overflow(structure)
    return _with_axis(structure, axis) if structure.directions else structure


def load_structure(path: Path | str, *, axis: str = "") -> Structure:
    """Return the structure that a file describes whose columns have names; docs/budget.md has the formats.

    Parameters
    ----------
    path : Path
    axis : str
        Axis of the mechanism, ``"rx"``, ``"ry"`` or ``"rz"``; refused where the file says another.

    Raises
    ------
    InputFileError
        The file is missing or wrong; one line with file, what was found and remedy.

    Examples
    --------
    >>> import mechid
    >>> mechid.load_structure("structure.toml").line_of_sight  # doctest: +SKIP
    ('x', 'y')
    """
    return read_structure(path, axis=axis)


def _refuse_overflow(structure: Structure) -> None:
    """Refuse a structure whose numbers, multiplied with one another, are none any more."""
    for direction, model in {structure.axis or "torque": structure.model, **structure.directions}.items():
        low, high = model.coverage_hz
        frequency_hz = np.geomspace(max(low, LOOKED_AT_HZ[0]), max(min(high, LOOKED_AT_HZ[1]), LOOKED_AT_HZ[0]), POINTS)
        with np.errstate(all="ignore"):
            size = np.abs(model.response(frequency_hz))
        lost = size > LARGEST if not isinstance(model, Modes) else ~(size <= LARGEST)
        refuse_no_numbers(f"{structure.name}: {direction}", frequency_hz, lost)


def _with_axis(structure: Structure, axis: str) -> Structure:
    """Return a structure of several directions, which needs to know which of them is the mechanism's."""
    axis = structure.axis or axis
    if not axis:
        raise InputFileError(f'{structure.name}: has several directions; say which is the mechanism\'s, axis = "rz"')
    if axis in structure.directions:
        raise InputFileError(
            f"{structure.name}: directions: {axis} is the mechanism's own, its interface; leave it out"
        )
    return replace(structure, axis=axis)


def _read(path: Path, selection: Selection) -> Structure:
    """Read, with the file's name in front of what the model itself refuses."""
    suffix = path.suffix.lower()
    try:
        refuse_special(path)
        return _guarded(path, selection) if suffix in GUARDED else READERS[suffix](path, selection)
    except OSError as error:
        raise InputFileError(f"{path.name}: cannot be read ({error.strerror or error}); check the path") from error
    except InputFileError as error:
        message = str(error)
        raise InputFileError(message if message.startswith(path.stem) else f"{path.name}: {message}") from error


def _guarded(path: Path, selection: Selection) -> Structure:
    """Read elsewhere; whatever a library, or what it made of the file, stumbles over is the user's one line."""
    suffix = path.suffix.lower()
    try:
        size = path.stat().st_size
        return call(GUARDED[suffix], path.absolute(), selection, size=size)
    except InputFileError:
        raise
    except Exception as error:
        what = str(error) if isinstance(error, UnreadableError) else f"{type(error).__name__}: {error}"
        raise InputFileError(
            f"{path.name}: is damaged, or no {suffix} file of a structure ({' '.join(what.split())[:160]}); "
            "write or copy it anew"
        ) from error
