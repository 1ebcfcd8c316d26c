"""Reader of modal tables in TOML format: ``line_of_sight`` names the axes, each mode is a ``[[mode]]`` table.

A mode may contain ``directions = { tx = 0.2, ... }``, the interface's motion along further directions.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.errors import InputFileError, did_you_mean
from mechid.reading.whole import read_text
from mechid.structure.damping import PERCENT, damping_key, damping_ratio
from mechid.structure.modes import Modes
from mechid.structure.selection import DIRECTIONS, ROTATIONS, Selection
from mechid.structure.structure import Structure

KEYS = ("axis", "line_of_sight", "mode")
MODE_KEYS = ("frequency_hz", "damping", PERCENT, "interface", "line_of_sight", "directions")


def read_modal_toml(path: Path, selection: Selection) -> Structure:
    """Read a modal table with mass-normalised shapes, in rad/(kg^0.5 m), and translations, in 1/kg^0.5.

    Raises
    ------
    InputFileError
        The file is not TOML, or an entry is unknown, missing or invalid.
    """
    selection.refuse_directions(path.name, "they stand in each [[mode]], as directions = { tx = 0.2 }")
    table = _table(path)
    names, axis = _names(table, path.name), _axis(table, path.name)
    entries = table.get("mode", [])
    if not isinstance(entries, list) or not entries:
        raise InputFileError(f"{path.name}: no mode; write one [[mode]] table for each")
    rows = [_mode(entry, f"{path.name}: mode[{k}]", len(names), selection) for k, entry in enumerate(entries)]
    numbers = np.array(rows)
    modes = Modes(numbers[:, 0], numbers[:, 1], numbers[:, 2], numbers[:, 3:].T.copy())
    along = {d: replace(modes, interface=shape) for d, shape in _directions(entries, path.name).items()}
    return Structure(name=path.name, line_of_sight=names, model=modes, axis=axis, directions=along)


def _directions(entries: Sequence[Mapping[str, Any]], label: str) -> dict[str, FloatArray]:
    """Return the interface's motion along further directions, (n,) over the modes; all modes have the same ones."""
    shapes: dict[str, list[float]] = {}
    for k, entry in enumerate(entries):
        place, own = f"{label}: mode[{k}]: directions", entry.get("directions", {})
        if not isinstance(own, dict):
            raise InputFileError(f"{place}: found {own}; write a table, as {{ tx = 0.2, ry = 0.1 }}")
        _refuse_unknown(own, DIRECTIONS, place)
        if k and set(own) != set(shapes):
            differs = sorted(set(own) ^ set(shapes))[0]
            raise InputFileError(f"{place}: {differs} is not in every mode; give the same directions in each")
        for direction, value in own.items():
            shapes.setdefault(direction, []).append(_number(value, f"{place}: {direction}"))
    return {direction: np.array(values) for direction, values in shapes.items()}


def _table(path: Path) -> dict[str, Any]:
    try:
        table = tomllib.loads(read_text(path))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputFileError(f"{path.name}: {error}; write name = value") from error
    _refuse_unknown(table, KEYS, path.name)
    return table


def _refuse_unknown(table: Mapping[str, Any], known: tuple[str, ...], place: str) -> None:
    for key in table:
        if key not in known:
            near = did_you_mean(key, known) or f"; the keys here are {', '.join(known)}"
            raise InputFileError(f"{place}: {key}: unknown key{near}")


def _names(table: Mapping[str, Any], label: str) -> tuple[str, ...]:
    names = table.get("line_of_sight")
    if not isinstance(names, list) or not names or not all(isinstance(name, str) and name for name in names):
        raise InputFileError(f'{label}: line_of_sight: name the axes, as line_of_sight = ["x", "y"]')
    return tuple(names)


def _axis(table: Mapping[str, Any], label: str) -> str:
    axis = table.get("axis", "")
    if axis and axis not in ROTATIONS:
        raise InputFileError(f'{label}: axis: found "{axis}"; write "rx", "ry" or "rz"')
    return str(axis)


def _mode(entry: Mapping[str, Any], place: str, axes: int, selection: Selection) -> list[float]:
    if not isinstance(entry, dict):
        raise InputFileError(f"{place}: found {entry}; write each mode as a table under [[mode]], in two brackets")
    _refuse_unknown(entry, MODE_KEYS, place)
    shape = entry.get("line_of_sight")
    if not isinstance(shape, list) or len(shape) != axes:
        raise InputFileError(f"{place}: line_of_sight: found {shape}; write {axes} numbers, one for each axis")
    head = [_number(entry.get(key), f"{place}: {key}") for key in ("frequency_hz", "interface")]
    own = [_number(value, f"{place}: line_of_sight[{k}]") for k, value in enumerate(shape)]
    return [head[0], _mode_damping(entry, place, selection), head[1], *own]


def _mode_damping(entry: Mapping[str, Any], place: str, selection: Selection) -> float:
    """Return a mode's damping ratio: its own, or else that of the selection."""
    key = damping_key(entry, place)
    if key not in entry and selection.damping is not None:
        return selection.damping
    return float(damping_ratio(_number(entry.get(key), f"{place}: {key}"), key, f"{place}: {key}"))


def _number(value: Any, place: str) -> float:
    # A bool is an int in Python, and TOML's true would pass for 1.
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputFileError(f"{place}: found {value}; write a finite number")
    return float(value)
