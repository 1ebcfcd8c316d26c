"""Modal table as TOML: ``line_of_sight`` names the axes, a ``[[mode]]`` table for each mode."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mechid.errors import InputFileError, did_you_mean
from mechid.structure.modes import Modes
from mechid.structure.selection import ROTATIONS, Selection
from mechid.structure.structure import Structure

KEYS = ("axis", "line_of_sight", "mode")
MODE_KEYS = ("frequency_hz", "damping", "interface", "line_of_sight")


def read_modal_toml(path: Path, selection: Selection) -> Structure:
    """Return the structure of a modal table; shapes are mass-normalised, in rad/(kg^0.5 m).

    Raises
    ------
    InputFileError
        The file is no TOML, or an entry is unknown, missing or wrong.
    """
    table = _table(path)
    names, axis = _names(table, path.name), _axis(table, path.name)
    entries = table.get("mode", [])
    if not isinstance(entries, list) or not entries:
        raise InputFileError(f"{path.name}: no mode; write one [[mode]] table for each")
    rows = [_mode(entry, f"{path.name}: mode[{k}]", len(names), selection) for k, entry in enumerate(entries)]
    numbers = np.array(rows)
    modes = Modes(numbers[:, 0], numbers[:, 1], numbers[:, 2], numbers[:, 3:].T.copy())
    return Structure(name=path.name, line_of_sight=names, model=modes, axis=axis)


def _table(path: Path) -> dict[str, Any]:
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8-sig"))
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
    _refuse_unknown(entry, MODE_KEYS, place)
    shape = entry.get("line_of_sight")
    if not isinstance(shape, list) or len(shape) != axes:
        raise InputFileError(f"{place}: line_of_sight: found {shape}; write {axes} numbers, one for each axis")
    damping = entry.get("damping", selection.damping)
    head = {"frequency_hz": entry.get("frequency_hz"), "damping": damping, "interface": entry.get("interface")}
    for key, value in {**head, **{f"line_of_sight[{k}]": v for k, v in enumerate(shape)}}.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise InputFileError(f"{place}: {key}: found {value}; write a finite number")
    return [float(value) for value in (*head.values(), *shape)]
