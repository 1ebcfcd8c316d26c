"""Universal files, data set 58: frequency responses by node and direction (needs the extra ``structures``)."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechid.errors import InputFileError
from mechid.structure.response import KINDS, to_receptance
from mechid.structure.response_csv import structure_of_responses
from mechid.structure.selection import DIRECTIONS, Location, Selection
from mechid.structure.structure import Structure
from mechid.units import conversion_factor

ComplexArray = NDArray[np.complex128]

FREQUENCY_RESPONSE = 4
"""Function type of a frequency response."""
DATA_TYPES = {8: 0, 11: 1, 12: 2}
"""Specific data types displacement, velocity, acceleration: how often differentiated."""
LENGTH_DATA = 8


def read_uff(path: Path, selection: Selection) -> Structure:
    """Return the structure of the frequency responses to the torque at the selected interface.

    Units other than SI have to stand in the axis labels; without labels SI is assumed and said.

    Raises
    ------
    InputFileError
        The file holds no such response, or its units are none of a response to a torque.
    """
    interface = selection.required_interface(path.name)
    sets = [entry for entry in _sets(path) if entry.get("func_type") == FREQUENCY_RESPONSE]
    excited = [entry for entry in sets if _at(entry, "ref") == (interface.node, interface.component)]
    if not excited:
        raise InputFileError(f"{path.name}: no response to {_text(interface)}; it holds {_held(sets)}")
    frequency_hz = np.asarray(excited[0]["x"], dtype=np.float64)
    found = {
        name: _combined(excited, locations, frequency_hz, path.name)
        for name, locations in selection.required_line_of_sight(path.name).items()
    }
    if any(_at(entry, "rsp") == (interface.node, interface.component) for entry in excited):
        found["interface"] = _combined(excited, (interface,), frequency_hz, path.name)
    structure = structure_of_responses(path.name, frequency_hz, found, interface.direction)
    labels = [entry for entry in excited if not _label(entry, "ordinate") or not _label(entry, "orddenom")]
    unsaid = f"{len(labels)} responses have no unit; they are read in SI, rotations in rad, torque in N m"
    return structure.with_warnings(unsaid) if labels else structure


def _sets(path: Path) -> Sequence[Mapping[str, Any]]:
    try:
        import pyuff
    except ImportError as error:
        raise InputFileError(f'{path.name}: reading it needs pyuff; pip install "mechid[structures]"') from error
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            file = pyuff.UFF(str(path))
            wanted = [k for k, kind in enumerate(file.get_set_types()) if int(kind) == 58]
            return [dict(file.read_sets(k)) for k in wanted]
    except Exception as error:
        raise InputFileError(f"{path.name}: cannot be read as a universal file ({error})") from error


def _at(entry: Mapping[str, Any], end: str) -> tuple[int, int]:
    return int(entry[f"{end}_node"]), abs(int(entry[f"{end}_dir"]))


def _sense(entry: Mapping[str, Any]) -> float:
    """Return the product of both directions' signs: -6 is the rotation about -z."""
    return float(np.sign(int(entry["rsp_dir"])) * np.sign(int(entry["ref_dir"])))


def _combined(
    excited: Sequence[Mapping[str, Any]], locations: Sequence[Location], frequency_hz: NDArray[np.float64], label: str
) -> ComplexArray:
    """Return the sum of the locations' receptances by their factors, (n,) rad/(N m)."""
    total = np.zeros(frequency_hz.size, dtype=np.complex128)
    for location in locations:
        there = [entry for entry in excited if _at(entry, "rsp") == (location.node, location.component)]
        if len(there) != 1:
            raise InputFileError(
                f"{label}: {len(there)} responses at {_text(location)} to this torque; it needs one: {_held(excited)}"
            )
        f = np.asarray(there[0]["x"], dtype=np.float64)
        if f.shape != frequency_hz.shape or not np.allclose(f, frequency_hz):
            raise InputFileError(f"{label}: the response at {_text(location)} has other frequencies than the first")
        total += location.factor * _sense(there[0]) * _receptance(there[0], location, f, label)
    return total


def _receptance(
    entry: Mapping[str, Any], location: Location, frequency_hz: NDArray[np.float64], label: str
) -> ComplexArray:
    values = np.asarray(entry["data"], dtype=np.complex128)
    differentiated = DATA_TYPES.get(int(entry.get("ordinate_spec_data_type", LENGTH_DATA) or LENGTH_DATA), 0)
    motion, torque = _label(entry, "ordinate"), _label(entry, "orddenom")
    if motion and torque:
        top = "m" if location.direction.startswith("t") else "rad"
        expected = next(kind.replace("rad", top, 1) for kind, times in KINDS.items() if times == differentiated)
        factor = conversion_factor(f"{motion}/({torque})", expected)
        if factor is None:
            raise InputFileError(f'{label}: {_text(location)}: unit "{motion}/({torque})"; expected {expected}')
        values = factor * values
    return to_receptance(frequency_hz, values[:, None], differentiated)[:, 0]


def _label(entry: Mapping[str, Any], which: str) -> str:
    text = str(entry.get(f"{which}_axis_units_lab", "") or "").strip()
    return "" if text.upper() in ("NONE", "") else text


def _text(location: Location) -> str:
    return f"node {location.node} {location.direction}"


def _held(sets: Sequence[Mapping[str, Any]]) -> str:
    ends = [(_at(entry, "rsp"), _at(entry, "ref")) for entry in sets[:8]]
    named = [f"{a[0]} {_direction(a[1])} to {b[0]} {_direction(b[1])}" for a, b in ends]
    return (", ".join(named) or "no frequency response") + ("" if len(sets) <= 8 else ", ...")


def _direction(code: int) -> str:
    return DIRECTIONS[code - 1] if 1 <= code <= len(DIRECTIONS) else str(code)
