"""Reader of universal files, data set 58: frequency responses by node and direction (extra ``structures``)."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.errors import InputFileError
from mechid.structure.response import KINDS, FrequencyResponse, to_receptance
from mechid.structure.response_csv import add_directions, load_unit, response_to_direction, structure_of_responses
from mechid.structure.selection import DIRECTIONS, Location, Selection
from mechid.structure.structure import Structure
from mechid.units import conversion_factor

FREQUENCY_RESPONSE = 4
"""UFF function type of a frequency response."""
DATA_TYPES = {8: 0, 11: 1, 12: 2}
"""Order of the time derivative by UFF data type: displacement, velocity, acceleration."""
LENGTH_DATA = 8


def read_uff(path: Path, selection: Selection) -> Structure:
    """Read the frequency responses to the torque at the selected interface.

    Units other than SI must be stated in the axis labels; without labels SI units are assumed, with a warning.

    Raises
    ------
    InputFileError
        The file contains no such response, or its units do not fit a response to a torque.
    """
    selection.refuse_directions(path.name, "they are those that it has responses to at the interface's node")
    interface = selection.required_interface(path.name)
    sets = [entry for entry in read_sets(path) if entry.get("func_type") == FREQUENCY_RESPONSE]
    excited = [entry for entry in sets if _node_and_component(entry, "ref") == (interface.node, interface.component)]
    if not excited:
        raise InputFileError(
            f"{path.name}: no response to {_describe_location(interface)}; it holds {_list_responses(sets)}"
        )
    frequency_hz = np.asarray(excited[0]["x"], dtype=np.float64)
    found = {
        name: _combine_locations(excited, locations, frequency_hz, path.name)
        for name, locations in selection.required_line_of_sight(path.name).items()
    }
    if any(_node_and_component(entry, "rsp") == (interface.node, interface.component) for entry in excited):
        found["interface"] = _combine_locations(excited, (interface,), frequency_hz, path.name)
    structure = structure_of_responses(path.name, frequency_hz, found, interface.direction)
    structure = add_directions(structure, _directions(sets, interface, selection, path.name))
    labels = [entry for entry in excited if not axis_label(entry, "ordinate") or not axis_label(entry, "orddenom")]
    unsaid = f"{len(labels)} responses have no unit; they are read in SI, rotations in rad, torque in N m"
    return structure.with_warnings(unsaid) if labels else structure


def _directions(
    sets: Sequence[Mapping[str, Any]], interface: Location, selection: Selection, label: str
) -> dict[str, FrequencyResponse]:
    """Return the responses to further directions at the interface's node that all lines of sight have."""
    found = {}
    places = selection.required_line_of_sight(label)
    for direction in DIRECTIONS:
        other = replace(interface, direction=direction)
        excited = [entry for entry in sets if _node_and_component(entry, "ref") == (other.node, other.component)]
        held = [_node_and_component(entry, "rsp") for entry in excited]
        whole = all(held.count((at.node, at.component)) == 1 for each in places.values() for at in each)
        if direction != interface.direction and excited and whole:
            frequency_hz = np.asarray(excited[0]["x"], dtype=np.float64)
            lines = [
                _combine_locations(excited, each, frequency_hz, label, load_unit(direction)) for each in places.values()
            ]
            found[direction] = response_to_direction(frequency_hz, lines)
    return found


def read_sets(path: Path) -> Sequence[Mapping[str, Any]]:
    """Return the data sets 58 of a universal file as pyuff has them.

    Raises
    ------
    InputFileError
        pyuff is not installed, or the file is none.
    """
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


def _node_and_component(entry: Mapping[str, Any], end: str) -> tuple[int, int]:
    return int(entry[f"{end}_node"]), abs(int(entry[f"{end}_dir"]))


def _sense(entry: Mapping[str, Any]) -> float:
    """Return the product of the signs of both directions; direction -6 is the rotation about -z."""
    return float(np.sign(int(entry["rsp_dir"])) * np.sign(int(entry["ref_dir"])))


def _combine_locations(
    excited: Sequence[Mapping[str, Any]],
    locations: Sequence[Location],
    frequency_hz: FloatArray,
    label: str,
    per: str = "N*m",
) -> ComplexArray:
    """Return the weighted sum of the receptances at locations, (n,), in rad/(N m) or rad/N."""
    total = np.zeros(frequency_hz.size, dtype=np.complex128)
    for location in locations:
        there = [entry for entry in excited if _node_and_component(entry, "rsp") == (location.node, location.component)]
        if len(there) != 1:
            raise InputFileError(
                f"{label}: found {len(there)} responses at {_describe_location(location)} to this torque, expected "
                f"one; it contains {_list_responses(excited)}"
            )
        f = np.asarray(there[0]["x"], dtype=np.float64)
        if f.shape != frequency_hz.shape or not np.allclose(f, frequency_hz):
            raise InputFileError(
                f"{label}: the frequencies of the response at {_describe_location(location)} differ from the first; "
                "export all responses at the same frequencies"
            )
        # pyuff returns the signs of directions as in the file: a response along -z counts negative.
        total += location.factor * _sense(there[0]) * _receptance(there[0], location, f, label, per)
    return total


def _receptance(
    entry: Mapping[str, Any], location: Location, frequency_hz: FloatArray, label: str, per: str
) -> ComplexArray:
    values = np.asarray(entry["data"], dtype=np.complex128)
    differentiated = DATA_TYPES.get(int(entry.get("ordinate_spec_data_type", LENGTH_DATA) or LENGTH_DATA), 0)
    motion, torque = axis_label(entry, "ordinate"), axis_label(entry, "orddenom")
    if motion and torque:
        top = "m" if location.direction.startswith("t") else "rad"
        kind = next(kind for kind, times in KINDS.items() if times == differentiated)
        expected = kind.replace("rad", top, 1).replace("N*m", per)
        factor = conversion_factor(f"{motion}/({torque})", expected)
        if factor is None:
            raise InputFileError(
                f'{label}: {_describe_location(location)}: unit "{motion}/({torque})"; expected {expected}'
            )
        values = factor * values
    return to_receptance(frequency_hz, values[:, None], differentiated)[:, 0]


def axis_label(entry: Mapping[str, Any], which: str) -> str:
    """Return the unit of an axis, ``"ordinate"`` or ``"orddenom"``; empty where none is stated."""
    text = str(entry.get(f"{which}_axis_units_lab", "") or "").strip()
    return "" if text.upper() in ("NONE", "") else text


def _describe_location(location: Location) -> str:
    return f"node {location.node} {location.direction}"


def _list_responses(sets: Sequence[Mapping[str, Any]]) -> str:
    ends = [(_node_and_component(entry, "rsp"), _node_and_component(entry, "ref")) for entry in sets[:8]]
    named = [f"{a[0]} {_direction(a[1])} to {b[0]} {_direction(b[1])}" for a, b in ends]
    return (", ".join(named) or "no frequency response") + ("" if len(sets) <= 8 else ", ...")


def _direction(code: int) -> str:
    return DIRECTIONS[code - 1] if 1 <= code <= len(DIRECTIONS) else str(code)
