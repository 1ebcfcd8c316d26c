"""``table_response`` entry of ``[bench]``: what the table makes of a load, as a file or as modes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mechid.arrays import FloatArray
from mechid.campaign.calibration_entry import read_units
from mechid.campaign.place import (
    Place,
    describe_entry,
    is_table_list,
    non_negative_number,
    one_of,
    positive_number,
    refuse_unknown_keys,
    required_entry,
    text,
)
from mechid.command.entry import is_table
from mechid.reading.whole import is_file

KEYS = ("file", "modes", "input_unit", "output_unit", "uncertainty_percent", "damping_uncertainty_percent")
MODE_KEYS = ("direction", "frequency_hz", "damping", "share")
DIRECTIONS = ("fx", "fy", "fz", "mx", "my", "mz")
SUFFIXES = (".csv", ".mat", ".uff", ".unv")
UNCERTAINTY_REMEDY = (
    "write its standard error, uncertainty_percent = 2.0: of the response in a file, of the frequencies of modes"
)
MODES_REMEDY = 'write a list of tables, as [{ direction = "fx", frequency_hz = 930.0, damping = 0.02 }]'
DAMPING_UNCERTAINTY = 0.3
"""Relative standard error of a mode's damping that none is stated of: hammer tests repeat it no better."""


@dataclass(frozen=True, kw_only=True)
class TableMode:
    """One mode of the table: the component that it acts in, 0 to 5, its frequency in Hz, damping ratio, and share."""

    component: int
    frequency_hz: float
    damping: float
    share: float


@dataclass(frozen=True, kw_only=True, eq=False)
class DeclaredResponse:
    """Table response as declared; a file is not read yet.

    Attributes
    ----------
    place : Place
        Of the entry, for messages.
    file : Path or None
    modes : tuple of TableMode
        Used where there is no file.
    uncertainty : float
        Relative standard error of the response in the file, or of the modes' frequencies.
    damping_uncertainty : float
        Relative, of the modes.
    input_factors, output_factors : ndarray or None, shape (6,)
        To N and N m, of the loads and of the table's output; None where the file states units.
    """

    place: Place
    file: Path | None
    modes: tuple[TableMode, ...]
    uncertainty: float
    damping_uncertainty: float
    input_factors: FloatArray | None = None
    output_factors: FloatArray | None = None


def read_table_response(entry: Any, place: Place, folder: Path) -> DeclaredResponse:
    """Return the declared response of the table.

    Raises
    ------
    InputFileError
        An entry is invalid, or the file is not there.
    """
    if not is_table(entry):
        raise place.error(
            f'{describe_entry(entry)}; write a table, as {{ file = "table.uff", uncertainty_percent = 2.0 }}'
        )
    refuse_unknown_keys(entry, KEYS, place)
    if ("modes" in entry) == ("file" in entry):
        found = "found both modes and file" if "modes" in entry else "found neither modes nor file"
        raise place.error(f'{found}; write one, as file = "table.uff", or modes = [...]')
    units = ("input_unit", "output_unit")
    modal = "modes" in entry
    for key in (*units, "damping_uncertainty_percent"):
        if key in entry and modal == (key in units):
            raise place.key(key).error(f"applies to {'a file' if modal else 'modes'} only; leave it out")
    if len(stated := [key for key in units if key in entry]) == 1:
        raise place.error(f"{stated[0]} stands alone; write both, {' and '.join(units)}")
    percent = required_entry(entry, "uncertainty_percent", place, UNCERTAINTY_REMEDY)
    damping = entry.get("damping_uncertainty_percent", 100.0 * DAMPING_UNCERTAINTY)
    return DeclaredResponse(
        place=place,
        file=None if modal else _file(entry["file"], place.key("file"), folder),
        modes=_modes(entry["modes"], place.key("modes")) if modal else (),
        uncertainty=0.01 * positive_number(percent, place.key("uncertainty_percent"), "%"),
        damping_uncertainty=0.01 * non_negative_number(damping, place.key("damping_uncertainty_percent"), "%"),
        input_factors=read_units(entry, units[0], place) if stated else None,
        output_factors=read_units(entry, units[1], place) if stated else None,
    )


def _file(entry: Any, place: Place, folder: Path) -> Path:
    name = text(entry, place, 'write the name of the file, as file = "table.uff"')
    path = folder / name
    if path.suffix.lower() not in SUFFIXES:
        raise place.error(f'no reader for "{path.suffix}"; mechid reads {", ".join(SUFFIXES)}')
    if not is_file(path):
        raise place.error(f"{name}: there is no such file beside {place.file}; check the path")
    return path


def _modes(entry: Any, place: Place) -> tuple[TableMode, ...]:
    if not is_table_list(entry) or not entry:
        raise place.error(f"{describe_entry(entry)}; {MODES_REMEDY}")
    modes = tuple(_mode(one, place.item(k), _count(entry, one)) for k, one in enumerate(entry))
    for component, direction in enumerate(DIRECTIONS):
        shares = [mode.share for mode in modes if mode.component == component]
        if shares and abs(sum(shares) - 1.0) > 1e-6:
            raise place.error(
                f"the shares of {direction} add up to {sum(shares):.6g}; write shares that add up to 1, since a "
                "static load is measured as it is"
            )
    return modes


def _count(entry: list[Mapping[str, Any]], one: Mapping[str, Any]) -> int:
    return sum(other.get("direction") == one.get("direction") for other in entry)


def _mode(one: Mapping[str, Any], place: Place, same: int) -> TableMode:
    refuse_unknown_keys(one, MODE_KEYS, place)
    direction = one_of(
        required_entry(one, "direction", place, 'write direction = "fx"'), DIRECTIONS, place.key("direction")
    )
    if same > 1:
        required_entry(one, "share", place, f"{direction} has {same} modes; write how much each carries, share = 0.7")
    frequency = required_entry(one, "frequency_hz", place, "write frequency_hz = 930.0")
    damping = required_entry(one, "damping", place, "write the share of critical damping, damping = 0.02")
    at = place.key("damping")
    zeta = positive_number(damping, at, "1")
    if zeta >= 1.0:
        raise at.error(f"found {zeta:.9g}; write the share of critical damping, below 1 (2 % is 0.02)")
    return TableMode(
        component=DIRECTIONS.index(direction),
        frequency_hz=positive_number(frequency, place.key("frequency_hz"), "Hz"),
        damping=zeta,
        share=positive_number(one.get("share", 1.0), place.key("share"), "1"),
    )
