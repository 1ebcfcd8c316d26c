"""The ``[[requirement]]`` tables of an emission specification."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign.place import (
    Place,
    describe_entry,
    flag,
    non_negative_number,
    number,
    one_of,
    positive_number,
    refuse_unknown_keys,
    required_entry,
    tables,
    text,
)
from mechid.specification.mask_file import read_mask_file
from mechid.specification.requirement import BAND_PEAK, DIRECTIONS, IN_BANDS, KINDS, PSD, Mask, Requirement, unit_of
from mechid.specification.settings import SPECIFICATION
from mechid.units.conversion import conversion_factor

MASK_FILE = "mask_file"
KEY = "requirement"
KEYS = (
    "name",
    "direction",
    "kind",
    "mask",
    MASK_FILE,
    "interpolation",
    "unit",
    "rates",
    "confidence",
    "margin_db",
    "exclude_mains",
    "resolution_hz",
)
POINTING_KEYS = ("limit_rad", "index")
"""Keys that requirements on the pointing error have, and those on the emission do not."""
EMISSION_KEYS = ("kind", "direction", "mask", "mask_file")
INTERPOLATIONS = ("log-log", "step")
MASK_REMEDY = "write two points or more of frequency in Hz and limit, as mask = [[10.0, 0.01], [100.0, 0.05]]"
RATES_REMEDY = 'write "all", or ranges in full steps/s, as rates = [[10.0, 50.0]]'
EXAMPLE_UNITS = {"N": "mN", "N*m": "mN*m", "N^2/Hz": "N^2/Hz", "N^2*m^2/Hz": "N^2*m^2/Hz"}


def is_on_pointing(entry: Mapping[str, Any]) -> bool:
    """Return whether an entry is on a pointing error, which a budget judges."""
    return any(key in entry for key in POINTING_KEYS)


def is_on_emission(entry: Mapping[str, Any]) -> bool:
    """Return whether an entry of a file that holds both kinds is on the emission."""
    return not is_on_pointing(entry) and any(key in entry for key in EMISSION_KEYS)


def read_requirements(table: Mapping[str, Any], place: Place, folder: Path) -> tuple[Requirement, ...]:
    """Return the emission requirements of a file, at least one; those on a pointing error are passed over.

    Parameters
    ----------
    table : mapping
        Content of the file.
    place : Place
        Of the file.
    folder : Path
        Against which the paths of mask files are taken.

    Raises
    ------
    InputFileError
        There is none, a key is unknown or missing, or an entry is wrong.
    """
    entries = [(entry, at) for entry, at in tables(table, KEY, place) if not is_on_pointing(entry)]
    if not entries:
        raise place.error(
            "no requirement; write one [[requirement]] table for each, or name a file with --requirements"
        )
    return _named_apart(entries, folder)


def read_requirements_beside(table: Mapping[str, Any], place: Place, folder: Path) -> tuple[Requirement, ...]:
    """Return the emission requirements of a file that may have others or none; parameters as `read_requirements`.

    Raises
    ------
    InputFileError
        A key is unknown or missing, or an entry is wrong.
    """
    return _named_apart([(entry, at) for entry, at in tables(table, KEY, place) if is_on_emission(entry)], folder)


def _named_apart(entries: Sequence[tuple[Mapping[str, Any], Place]], folder: Path) -> tuple[Requirement, ...]:
    made = tuple(_requirement(entry, at, folder) for entry, at in entries)
    names = [one.name for one in made]
    for k, (_, at) in enumerate(entries):
        if names[k] in names[:k]:
            other = entries[names.index(names[k])][1]
            raise at.key("name").error(f'"{names[k]}" is also the name of {other.path}; give each its own')
    return made


def _requirement(entry: Mapping[str, Any], place: Place, folder: Path) -> Requirement:
    refuse_unknown_keys(entry, KEYS, place)
    name = text(required_entry(entry, "name", place, 'write name = "Fx exported"'), place.key("name"), "write a name")
    direction = required_entry(entry, "direction", place, 'write direction = "fx"')
    direction = one_of(direction, DIRECTIONS, place.key("direction"))
    kind = one_of(required_entry(entry, "kind", place, 'write kind = "amplitude"'), KINDS, place.key("kind"))
    confidence = number(entry.get("confidence", 0.95), place.key("confidence"), "1")
    if not 0.5 <= confidence < 1.0:
        raise place.key("confidence").error(f"found {confidence:.9g}; write a share from 0.5 to below 1, as 0.95")
    return Requirement(
        name=name,
        direction=direction,
        kind=kind,
        mask=_mask(entry, place, folder, unit_of(direction, kind), kind),
        rates=_rates(entry.get("rates", "all"), place.key("rates")),
        confidence=confidence,
        margin_db=non_negative_number(entry.get("margin_db", 0.0), place.key("margin_db"), "dB"),
        exclude_mains=_exclude_mains(entry, place, kind),
        resolution_hz=_resolution(entry, place, kind),
    )


def _exclude_mains(entry: Mapping[str, Any], place: Place, kind: str) -> bool:
    excluded = flag(entry.get("exclude_mains", False), place.key("exclude_mains"))
    if excluded and kind == BAND_PEAK:
        raise place.key("exclude_mains").error("a peak over time holds all lines of its band; leave it out")
    return excluded


def _resolution(entry: Mapping[str, Any], place: Place, kind: str) -> float:
    if "resolution_hz" in entry and kind != PSD:
        raise place.key("resolution_hz").error(
            f'it is the bin width of kind = "{PSD}", and this is "{kind}"; leave it out'
        )
    return positive_number(entry.get("resolution_hz", SPECIFICATION.resolution_hz), place.key("resolution_hz"), "Hz")


def _mask(entry: Mapping[str, Any], place: Place, folder: Path, unit: str, kind: str) -> Mask:
    interpolation = one_of(
        entry.get("interpolation", INTERPOLATIONS[kind in IN_BANDS]), INTERPOLATIONS, place.key("interpolation")
    )
    if kind in IN_BANDS and interpolation != INTERPOLATIONS[1]:
        raise place.key("interpolation").error(
            f'found "{interpolation}"; kind = "{kind}" has one limit for each band between two points: write "step"'
        )
    if ("mask" in entry) == (MASK_FILE in entry):
        both = "mask and mask_file are both there; keep one" if "mask" in entry else f"missing; {MASK_REMEDY}"
        raise place.key("mask").error(both)
    if MASK_FILE in entry:
        if "unit" in entry:
            raise place.key("unit").error("the header of the mask file says the unit; leave it out")
        at = place.key(MASK_FILE)
        name = text(entry[MASK_FILE], at, 'write the name of a CSV or XLSX file, as mask_file = "fx.csv"')
        frequency, limit, file_unit = read_mask_file(folder / name, at)
        limit = _in_si(limit, file_unit, unit, at)
    else:
        frequency, limit = _points(entry["mask"], place.key("mask"))
        example = EXAMPLE_UNITS[unit]
        given = text(
            required_entry(entry, "unit", place, f'write the unit of the limits, as unit = "{example}"'),
            place.key("unit"),
            f'write the unit as a text, as unit = "{example}"',
        )
        limit, at = _in_si(limit, given, unit, place.key("unit")), place.key("mask")
    _refuse_unordered(frequency, limit, at)
    return Mask(frequency, limit, interpolation == INTERPOLATIONS[1])


def _points(entry: Any, place: Place) -> tuple[FloatArray, FloatArray]:
    if not isinstance(entry, list) or len(entry) < 2:
        raise place.error(f"{describe_entry(entry)}; {MASK_REMEDY}")
    points = []
    for k, point in enumerate(entry):
        if not isinstance(point, list) or len(point) != 2:
            raise place.item(k).error(f"{describe_entry(point)}; {MASK_REMEDY}")
        points.append([number(value, place.item(k), "") for value in point])
    columns = np.array(points, dtype=np.float64).T
    return columns[0], columns[1]


def _refuse_unordered(frequency: FloatArray, limit: FloatArray, place: Place) -> None:
    if frequency.size < 2:
        raise place.error(f"found {frequency.size} points; {MASK_REMEDY}")
    for k in range(frequency.size):
        if not (frequency[k] > 0.0 and limit[k] > 0.0):
            raise place.item(k).error(f"found [{frequency[k]:.9g}, {limit[k]:.9g}]; write two numbers above 0")
        if k and frequency[k] <= frequency[k - 1]:
            how = "repeats" if frequency[k] == frequency[k - 1] else "falls below"
            raise place.item(k).error(
                f"{frequency[k]:.9g} Hz {how} {frequency[k - 1]:.9g} Hz; write the points by ascending frequency, and "
                'a jump with interpolation = "step"'
            )


def _in_si(limit: FloatArray, unit: str, to: str, place: Place) -> FloatArray:
    """Return limits in SI; a power density may be given by its root, as N/Hz^0.5."""
    factor = conversion_factor(unit, to)
    if factor is not None:
        return limit * factor
    root = {"N^2/Hz": "N/Hz^0.5", "N^2*m^2/Hz": "N*m/Hz^0.5"}.get(to)
    factor = conversion_factor(unit, root) if root else None
    if factor is not None:
        return np.asarray((limit * factor) ** 2, dtype=np.float64)
    raise place.error(f'found "{unit}"; write a unit of {to}, as "{EXAMPLE_UNITS[to]}"')


def _rates(entry: Any, place: Place) -> tuple[tuple[float, float], ...]:
    if entry == "all":
        return ()
    if not isinstance(entry, list) or not entry:
        raise place.error(f"{describe_entry(entry)}; {RATES_REMEDY}")
    ranges = []
    for k, pair in enumerate(entry):
        at = place.item(k)
        if not isinstance(pair, list) or len(pair) != 2:
            raise at.error(f"{describe_entry(pair)}; {RATES_REMEDY}")
        low, high = (non_negative_number(value, at, "full steps/s") for value in pair)
        if low > high:
            raise at.error(f"found [{low:.9g}, {high:.9g}]; write the lower rate first")
        ranges.append((low, high))
    return tuple(ranges)
