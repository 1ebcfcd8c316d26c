"""Readers of Nastran models by pyYeti (needs the extra ``structures``): solved modes and Craig-Bampton matrices.

- ``.op2`` with an ``.op4`` of the same name, as written by the DMAP NAS2CAM: modes of the system.
- ``.op4`` with an ``.asm`` of the same name: Craig-Bampton model, KXX and MXX over boundary and modal degrees of
  freedom, whose free modes are solved here.

Both use the units of the model and an output frame per grid; shapes are transformed to the basic frame and to SI units.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import LinAlgError, eigh

from mechid.arrays import BoolArray, FloatArray
from mechid.errors import InputFileError
from mechid.structure.modal_csv import selected_damping
from mechid.structure.modes import RIGID_BELOW_HZ, Modes
from mechid.structure.selection import DIRECTIONS, Location, Selection
from mechid.structure.structure import Structure, structure_from_directions

RECTANGULAR = 1
ASYMMETRY = 1e-6
"""Maximum asymmetry of a mass or stiffness matrix, relative to its largest entry."""
RIGID_SHARE = 1e-4
"""A solved mode below this share of the lowest elastic frequency is a rigid-body mode with rounding errors."""
RIGID_BODY_MODES = 6


def read_nas2cam(path: Path, selection: Selection) -> Structure:
    """Read the modes solved by Nastran from a NAS2CAM pair, ``.op2`` and ``.op4``.

    Raises
    ------
    InputFileError
        pyYeti or the second file is missing, the files cannot be read, or a degree of freedom does not exist.
    """
    nastran = _pyyeti(path.name)
    _companion_file(path, ".op4", "the matrices of the pair")
    content = _read(path, lambda: nastran.op2.rdnas2cam(str(path.with_suffix(""))))
    try:
        uset, eigenvalues, shapes = content["uset"][0], content["lambda"][0], content["phg"][0]
    except KeyError as error:
        raise InputFileError(
            f"{path.name}: holds no {error} of the residual; write it with PARAM,PRFMODES,1"
        ) from error
    return _structure(path.name, uset, np.asarray(eigenvalues), np.asarray(shapes), selection)


def read_craig_bampton(path: Path, selection: Selection) -> Structure:
    """Read a Craig-Bampton model, ``.op4`` and ``.asm``, and solve its free modes.

    Raises
    ------
    InputFileError
        pyYeti or the second file is missing, the matrices are not symmetric or differ in size, or a degree of freedom
        does not exist.
    """
    nastran = _pyyeti(path.name)
    asm = _companion_file(path, ".asm", "the grids of the boundary")
    content = _read(path, lambda: nastran.op4.read(str(path)))
    stiffness, mass = (_matrix(content, name, path.name) for name in ("kxx", "mxx"))
    # The optional .pch file lists the degrees of freedom if the boundary does not have all six of each grid.
    punched = asm.with_suffix(".pch")
    for cards in (asm, punched):
        refuse_other_files(cards)
    uset = _read(asm, lambda: nastran.bulk.asm2uset(str(asm), try_rdextrn=punched.is_file()))[0]
    if len(uset) != stiffness.shape[0]:
        raise InputFileError(
            f"{asm.name}: has {len(uset)} degrees of freedom, but kxx has {stiffness.shape[0]}; export both together"
        )
    eigenvalues, shapes = solve_modes(stiffness, mass, path.name)
    return _structure(path.name, uset, eigenvalues, shapes, selection)


def solve_modes(stiffness: FloatArray, mass: FloatArray, label: str) -> tuple[FloatArray, FloatArray]:
    """Return eigenvalues (n,) and mass-normalised shapes (n_dof, n) of K phi = lambda M phi.

    Raises
    ------
    InputFileError
        A matrix is not symmetric, or the mass matrix is not positive definite.
    """
    for name, matrix in (("kxx", stiffness), ("mxx", mass)):
        if matrix.shape != stiffness.shape or np.abs(matrix - matrix.T).max() > ASYMMETRY * np.abs(matrix).max():
            raise InputFileError(f"{label}: {name} {matrix.shape} is not symmetric, or differs in size from the other")
    try:
        # The remaining asymmetry is rounding, but eigh would use one triangle only.
        values, shapes = eigh(0.5 * (stiffness + stiffness.T), 0.5 * (mass + mass.T))
    except LinAlgError as error:
        raise InputFileError(f"{label}: mxx is not positive definite; give every degree of freedom a mass") from error
    return np.asarray(values), np.asarray(shapes)


def _structure(label: str, uset: Any, eigenvalues: FloatArray, shapes: FloatArray, selection: Selection) -> Structure:
    selection.refuse_directions(label, "its six directions are those of the interface's node")
    interface = selection.required_interface(label)
    unit = 1.0 / np.sqrt(selection.mass_unit_kg)
    lines = selection.required_line_of_sight(label)
    rows = [sum(place.factor * _motion(place, uset, shapes, label, selection) for place in p) for p in lines.values()]
    frequency_hz = np.sqrt(np.maximum(eigenvalues, 0.0)) / (2.0 * np.pi)
    modes = {
        direction: Modes(
            np.where(_rigid_body_mask(eigenvalues), 0.0, frequency_hz),
            selected_damping(selection, label, eigenvalues.size),
            unit * _motion(replace(interface, direction=direction), uset, shapes, label, selection),
            unit * np.array(rows),
        )
        for direction in DIRECTIONS
    }
    if selection.highest_hz is not None:
        modes = {direction: own.up_to(selection.highest_hz) for direction, own in modes.items()}
    return structure_from_directions(label, tuple(lines), modes, interface.direction)


def _rigid_body_mask(eigenvalues: FloatArray) -> BoolArray:
    """Return the mask of modes so far below the first elastic mode that their frequencies are rounding errors."""
    frequency = np.sqrt(np.abs(eigenvalues)) / (2.0 * np.pi)
    elastic = np.sort(frequency)[RIGID_BODY_MODES] if frequency.size > RIGID_BODY_MODES else np.inf
    return np.asarray(frequency < max(RIGID_BELOW_HZ, RIGID_SHARE * elastic if np.isfinite(elastic) else 0.0))


def _motion(place: Location, uset: Any, shapes: FloatArray, label: str, selection: Selection) -> FloatArray:
    """Return the modes' motion at a location in the basic frame, (n,); rotations are divided by the length unit."""
    grids = uset.index.get_level_values("id")
    rows = np.flatnonzero(grids == place.node)
    if rows.size != 6:
        known = ", ".join(str(g) for g in dict.fromkeys(grids[uset.index.get_level_values("dof") > 0]))
        raise InputFileError(f"{label}: no grid {place.node}; it holds {known}")
    table = uset.iloc[rows][["x", "y", "z"]].to_numpy(dtype=np.float64)
    if int(table[1, 1]) != RECTANGULAR:
        raise InputFileError(
            f"{label}: grid {place.node} has a cylindrical or spherical output frame; make it rectangular"
        )
    # Rows 3 to 5 of pyYeti's table are the transformation from the grid's output frame to the basic frame.
    part = slice(0, 3) if place.direction.startswith("t") else slice(3, 6)
    motion = table[3:] @ shapes[rows[part]]
    # Mass-normalised rotations are in rad/(mass^0.5 length), translations in 1/mass^0.5.
    scale = 1.0 if place.direction.startswith("t") else 1.0 / selection.length_unit_m
    return np.asarray(scale * motion[(place.component - 1) % 3], dtype=np.float64)


def _matrix(content: Mapping[str, Any], name: str, label: str) -> FloatArray:
    if name not in content:
        raise InputFileError(f"{label}: no matrix {name}; it holds {', '.join(content)}")
    matrix = content[name]
    return np.asarray(matrix.toarray() if hasattr(matrix, "toarray") else matrix, dtype=np.float64)


def _companion_file(path: Path, suffix: str, content: str) -> Path:
    other = path.with_suffix(suffix)
    if not other.is_file():
        raise InputFileError(f"{path.name}: needs {other.name} in the same folder; it contains {content}")
    return other


def refuse_other_files(path: Path) -> None:
    """Raise an error for bulk data with an include statement: pyYeti would read any file that it names."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines() if path.is_file() else []
    for number, line in enumerate(lines, 1):
        if line.lstrip().lower().startswith("include"):
            raise InputFileError(
                f"{path.name}: line {number}: {line.strip()[:80]}: included files are not read; copy their lines here"
            )


def _pyyeti(label: str) -> Any:
    try:
        # Importing pyYeti changes NumPy's global print options.
        with np.printoptions():
            from pyyeti import nastran
            from pyyeti.nastran import bulk, op2, op4
    except ImportError as error:
        raise InputFileError(f'{label}: reading it needs pyYeti; pip install "mechid[structures]"') from error
    # They are attributes of nastran once imported.
    del bulk, op2, op4
    return nastran


def _read(path: Path, read: Any) -> Any:
    """Call a reader of pyYeti and convert its errors."""
    # pyYeti does not validate its input: malformed files raise exceptions of any type.
    try:
        return read()
    except Exception as error:
        raise InputFileError(f"{path.name}: cannot be read ({' '.join(str(error).split())[:120]})") from error
