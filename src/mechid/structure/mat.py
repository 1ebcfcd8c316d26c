"""Reader of MATLAB files up to version 7 with frequency responses, modes or a state space.

The names of the variables determine the kind of model:

- ``frequency_hz`` (n), ``line_of_sight`` (n, m) complex, optionally ``interface`` (n) complex: frequency responses;
- ``frequency_hz`` (n), ``damping`` or ``damping_percent`` (n or 1), ``interface`` (n), ``line_of_sight`` (m, n): modes;
- ``A``, ``B``, ``C``, ``D``: state space with the interface as first output.

Optional variables are ``line_of_sight_names``, the names of the axes, and ``unit``, that of a frequency response.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat, matlab

from mechid.errors import InputFileError
from mechid.structure.damping import PERCENT, damping_key, damping_ratio
from mechid.structure.linear_system import LinearSystem, check_system
from mechid.structure.modes import Modes
from mechid.structure.response_csv import receptance_of, structure_of_responses
from mechid.structure.selection import Selection
from mechid.structure.structure import Structure

EXPECTED = "frequency_hz and line_of_sight, or A, B, C and D"


def read_mat(path: Path, selection: Selection) -> Structure:
    """Read the structure of a MAT file.

    Raises
    ------
    InputFileError
        The file is not a MAT file up to version 7, or its variables do not describe a structure.
    """
    selection.refuse_directions(path.name, "a MAT file gives the torque's direction alone")
    content = _content(path)
    if "A" in content:
        return _system(content, path.name)
    for name in ("frequency_hz", "line_of_sight"):
        if name not in content:
            held = ", ".join(key for key in content if not key.startswith("__"))
            raise InputFileError(f'{path.name}: no variable "{name}"; it holds {held}, expected {EXPECTED}')
    is_modal = "damping" in content or PERCENT in content or not np.iscomplexobj(content["line_of_sight"])
    return _modes(content, path.name, selection) if is_modal else _responses(content, path.name)


def _content(path: Path) -> dict[str, Any]:
    try:
        return dict(loadmat(path))
    except NotImplementedError as error:
        raise InputFileError(f'{path.name}: is of version 7.3; save it with "-v7"') from error
    except (matlab.MatReadError, ValueError) as error:
        raise InputFileError(f"{path.name}: is not a MAT file ({error}); export or copy it again") from error


def _names(content: Mapping[str, Any], count: int, label: str) -> tuple[str, ...]:
    if "line_of_sight_names" not in content:
        return tuple(f"los_{k + 1}" for k in range(count))
    names = tuple(str(np.ravel(name)[0]).strip() for name in np.ravel(content["line_of_sight_names"]))
    if len(names) != count:
        raise InputFileError(f"{label}: line_of_sight_names: {len(names)} names for {count} lines of sight")
    return names


def _responses(content: Mapping[str, Any], label: str) -> Structure:
    f = np.ravel(content["frequency_hz"]).astype(np.float64)
    values = np.atleast_2d(content["line_of_sight"])
    # MATLAB users store responses by rows or by columns; the number of frequencies decides.
    values = values if values.shape[0] == f.size else values.T
    if values.shape[0] != f.size:
        raise InputFileError(f"{label}: line_of_sight is {values.shape}, but frequency_hz has {f.size} values")
    named = dict(zip(_names(content, values.shape[1], label), values.T, strict=True))
    if "interface" in content:
        named = {"interface": np.ravel(content["interface"]), **named}
    unit = str(np.ravel(content["unit"])[0]) if "unit" in content else None
    place = f"{label}: unit"
    found = {k: receptance_of(f, np.asarray(v, dtype=np.complex128), unit, place) for k, v in named.items()}
    return structure_of_responses(label, f, found)


def _modes(content: Mapping[str, Any], label: str, selection: Selection) -> Structure:
    f = np.ravel(content["frequency_hz"]).astype(np.float64)
    key = damping_key(content, label)
    if (key not in content and selection.damping is None) or "interface" not in content:
        missing = "interface" if key in content or selection.damping is not None else "damping"
        raise InputFileError(f'{label}: no variable "{missing}"; modes need it')
    shapes = np.atleast_2d(content["line_of_sight"]).astype(np.float64)
    try:
        given = np.ravel(content[key]).astype(np.float64) if key in content else None
        damping = selection.damping if given is None else damping_ratio(given, key, key)
        zeta = np.broadcast_to(np.asarray(damping, dtype=np.float64), f.shape).copy()
        modes = Modes(f, zeta, np.ravel(content["interface"]).astype(np.float64), shapes)
    except (InputFileError, ValueError) as error:
        raise InputFileError(f"{label}: {error}") from error
    return Structure(name=label, line_of_sight=_names(content, shapes.shape[0], label), model=modes)


def _system(content: Mapping[str, Any], label: str) -> Structure:
    if missing := [name for name in "BC" if name not in content]:
        raise InputFileError(f'{label}: no variable "{missing[0]}" beside A; a state space needs A, B, C')
    A, B, C = (np.atleast_2d(content[name]).astype(np.float64) for name in "ABC")
    D = np.atleast_2d(content.get("D", np.zeros((C.shape[0], 1)))).astype(np.float64)
    if A.shape[0] != A.shape[1] or B.shape != (A.shape[0], 1) or C.shape[1] != A.shape[0] or C.shape[0] < 2:
        raise InputFileError(
            f"{label}: A {A.shape}, B {B.shape}, C {C.shape}; it needs one input, the torque, and as first output "
            "the interface"
        )
    return check_system(LinearSystem(A, B, C, D), _names(content, C.shape[0] - 1, label), "", label)
