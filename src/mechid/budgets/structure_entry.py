"""Reader of the ``[structure]`` table of a budget file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.damping_entry import required_damping
from mechid.budgets.settings import RESIDUALS
from mechid.budgets.side_source import FRAME
from mechid.campaign.place import Place, found, number, one_of, refuse_unknown_keys, required, tables, text
from mechid.command.entry import is_table, is_whole
from mechid.errors import InputFileError
from mechid.records.components import AXES
from mechid.structure import Location, Modes, Selection, Structure, read_structure
from mechid.structure.damping import CONTROL_ASKED_ABOVE
from mechid.structure.damping import KEYS as DAMPING_KEYS
from mechid.structure.selection import DIRECTIONS, ROTATIONS

KEYS = (
    "file",
    "interface",
    "line_of_sight",
    *DAMPING_KEYS,
    "length_unit_m",
    "mass_unit_kg",
    "highest_hz",
    "attitude_control",
    "coupled_below_hz",
    "directions",
    "frame",
)
OF_BUDGET = ("attitude_control", "coupled_below_hz", "frame")
"""Keys that apply with a structure from memory too."""
TABLE_REMEDY = "write a table, [structure]"
LOCATION_KEYS = ("node", "direction", "factor")
LINE_KEYS = ("name", *LOCATION_KEYS)
LOCATION_REMEDY = 'write { node = 3, direction = "rz" }'
COUPLED_BELOW_HZ = 150.0


def read_structure_entry(
    table: Mapping[str, Any], place: Place, folder: Path, given: Structure | None = None
) -> tuple[Structure, float]:
    """Return the structure, and the frequency in Hz up to which its modes are coupled with the mechanism.

    A structure that is `given` replaces the file's.

    Raises
    ------
    InputFileError
        An entry or the structure's file is missing or wrong.
    """
    at = place.key("structure")
    entry = required({"structure": {}} | dict(table) if given else table, "structure", place, TABLE_REMEDY)
    if not is_table(entry):
        raise at.error(f"{found(entry)}; {TABLE_REMEDY}")
    refuse_unknown_keys(entry, KEYS if given is None else OF_BUDGET, at)
    coupled = number(entry.get("coupled_below_hz", COUPLED_BELOW_HZ), at.key("coupled_below_hz"), "Hz")
    if given is not None:
        return _with_attitude_control(given, entry, at), coupled
    file = text(required(entry, "file", at, 'write file = "structure.toml"'), at.key("file"), "write a file's name")
    axis = one_of(table["axis"], ROTATIONS, place.key("axis")) if "axis" in table else ""
    try:
        structure = read_structure(folder / file, _selection(entry, at), axis=axis)
    except InputFileError as error:
        raise InputFileError(
            str(error) if str(error).startswith(place.file) else f"{at.key('file')}: {error}"
        ) from error
    return _with_attitude_control(structure, entry, at), coupled


def _selection(entry: Mapping[str, Any], place: Place) -> Selection:
    lines: dict[str, tuple[Location, ...]] = {}
    for line, at in tables(entry, "line_of_sight", place):
        refuse_unknown_keys(line, LINE_KEYS, at)
        name = text(required(line, "name", at, 'write name = "x"'), at.key("name"), "write a name")
        lines[name] = (*lines.get(name, ()), _location(line, at))
    numbers: dict[str, Any] = {
        key: number(entry[key], place.key(key), unit)
        for key, unit in (("length_unit_m", "m"), ("mass_unit_kg", "kg"), ("highest_hz", "Hz"))
        if key in entry
    }
    if any(key in entry for key in DAMPING_KEYS):
        numbers["damping"] = required_damping(entry, place, "")
    interface = None
    if "interface" in entry:
        if not is_table(entry["interface"]):
            raise place.key("interface").error(f"{found(entry['interface'])}; {LOCATION_REMEDY}")
        refuse_unknown_keys(entry["interface"], LOCATION_KEYS, place.key("interface"))
        interface = _location(entry["interface"], place.key("interface"))
    directions = _named_directions(entry, place.key("directions"))
    return replace(Selection(interface=interface, line_of_sight=lines, directions=directions), **numbers)


def _named_directions(entry: Mapping[str, Any], place: Place) -> dict[str, str]:
    """Return the columns of a file for the interface's further directions."""
    named, remedy = entry.get("directions", {}), 'write the names of columns, as { tx = "phi_x", ry = "theta_y" }'
    if not is_table(named):
        raise place.error(f"{found(named)}; {remedy}")
    refuse_unknown_keys(named, DIRECTIONS, place)
    return {direction: text(name, place.key(direction), remedy) for direction, name in named.items()}


def read_frame(table: Mapping[str, Any], place: Place) -> FloatArray:
    """Return the axes of the bench in the structure's frame as columns, (3, 3); the same axes without an entry.

    Raises
    ------
    InputFileError
        They are not three right-handed directions at right angles to one another.
    """
    entry, at = table.get("structure", {}).get("frame"), place.key("structure").key("frame")
    if entry is None:
        return np.eye(3)
    if not is_table(entry):
        raise at.error(f"{found(entry)}; write {FRAME}")
    refuse_unknown_keys(entry, AXES, at)
    frame = np.column_stack([_cosines(required(entry, axis, at, f"write {FRAME}"), at.key(axis)) for axis in AXES])
    if np.abs(frame.T @ frame - np.eye(3)).max() > RESIDUALS.along:
        raise at.error("the axes are not of length 1 and at right angles to one another; write their cosines")
    if np.linalg.det(frame) < 0.0:
        raise at.error("the axes are left-handed: z is not x turned into y; check their signs")
    # The nearest rotation: cosines typed with few digits are not exactly orthogonal.
    left, _, right = np.linalg.svd(frame)
    return np.asarray(left @ right)


def _cosines(entry: Any, place: Place) -> list[float]:
    if not isinstance(entry, list) or len(entry) != 3:
        raise place.error(f"{found(entry)}; write three cosines, as [0.0, 1.0, 0.0]")
    return [number(value, place.item(k), "1") for k, value in enumerate(entry)]


def _location(entry: Mapping[str, Any], place: Place) -> Location:
    node = required(entry, "node", place, LOCATION_REMEDY)
    if not is_whole(node, 0, 2**31):
        raise place.key("node").error(f"{found(node)}; write the node's number")
    direction = one_of(required(entry, "direction", place, LOCATION_REMEDY), DIRECTIONS, place.key("direction"))
    return Location(int(node), direction, number(entry.get("factor", 1.0), place.key("factor"), "1 or rad/m"))


def _with_attitude_control(structure: Structure, entry: Mapping[str, Any], place: Place) -> Structure:
    """Return the structure with its rigid body held, if attitude control is given."""
    if "attitude_control" not in entry:
        return structure
    at, control = place.key("attitude_control"), entry["attitude_control"]
    remedy = "write { bandwidth_hz = 0.05, damping = 0.7 }"
    if not is_table(control):
        raise at.error(f"{found(control)}; {remedy}")
    refuse_unknown_keys(control, ("bandwidth_hz", *DAMPING_KEYS), at)
    if not isinstance(structure.model, Modes):
        raise at.error("it needs the structure's modes; put the control into the response, or leave it out")
    bandwidth = number(required(control, "bandwidth_hz", at, remedy), at.key("bandwidth_hz"), "Hz")
    damping = required_damping(control, at, remedy, asked_above=CONTROL_ASKED_ABOVE)
    held = {
        direction: model.with_attitude_control(bandwidth, damping)
        for direction, model in structure.directions.items()
        if isinstance(model, Modes)
    }
    return replace(structure, model=structure.model.with_attitude_control(bandwidth, damping), directions=held)
