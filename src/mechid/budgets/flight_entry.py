"""Reader of the ``[flight]`` table: values that replace those of the bench, their uncertainty and their spread."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from mechid.budgets.damping_entry import required_damping
from mechid.campaign.place import (
    Place,
    above_zero,
    found,
    number,
    refuse_unknown_keys,
    required,
    tables,
)
from mechid.command.entry import is_table
from mechid.structure.damping import KEYS as DAMPING_KEYS

LOAD_INERTIA = "load.inertia"
SHORT = {
    "load_inertia": LOAD_INERTIA,
    "peak_voltage": "stepper.peak_voltage",
    "peak_current": "stepper.peak_current",
}
KEYS = (*SHORT, "values", "uncertain", "spread", "load_mode")
LOAD_MODE_KEYS = ("frequency_hz", *DAMPING_KEYS, "inertia")


@dataclass(frozen=True)
class LoadMode:
    """Cantilever mode of the load: frequency in Hz, damping, effective inertia in kg m2 about the axis."""

    frequency_hz: float
    damping: float
    inertia: float


@dataclass(frozen=True)
class Flight:
    """Differences between flight and bench.

    Parameters
    ----------
    values : mapping of dotted name to value
        In the mechanism file's units: other voltage, load, or temperature.
    spread : mapping of dotted name to standard deviation
        From unit to unit, over temperature, of the voltage: the ensemble of the requirements.
    uncertain : mapping of dotted name to standard deviation
        For values that are neither estimated nor exactly known, such as voltage or flight load: part of the band.
    load_modes : tuple of LoadMode
        Their inertias are part of the load's.
    place : str
        Position in the file, for messages.
    """

    values: Mapping[str, float] = field(default_factory=dict)
    spread: Mapping[str, float] = field(default_factory=dict)
    uncertain: Mapping[str, float] = field(default_factory=dict)
    load_modes: tuple[LoadMode, ...] = ()
    place: str = "flight"


def read_flight(entry: Any, place: Place) -> Flight:
    """Return the table's content; parameter names are checked against the estimate later.

    Raises
    ------
    InputFileError
        A key is unknown or an entry is wrong.
    """
    if not is_table(entry):
        raise place.error(f"{found(entry)}; write a table, [flight]")
    refuse_unknown_keys(entry, KEYS, place)
    values = {SHORT[key]: number(entry[key], place.key(key), "SI units") for key in SHORT if key in entry}
    values |= _numbers(entry.get("values", {}), place.key("values"))
    spread, uncertain = (_deviations(entry.get(key, {}), place.key(key)) for key in ("spread", "uncertain"))
    modes = tuple(_load_mode(mode, at) for mode, at in tables(entry, "load_mode", place))
    return Flight(values, spread, uncertain, modes, str(place))


def _numbers(entry: Any, place: Place) -> dict[str, float]:
    """Return dotted names with numbers; nested tables, which TOML makes of dotted keys, are flattened."""
    if not is_table(entry):
        raise place.error(f'{found(entry)}; write a table, as {{ "stepper.coil_resistance" = 11.2 }}')
    out: dict[str, float] = {}
    for key, value in entry.items():
        if is_table(value):
            out |= {f"{key}.{name}": v for name, v in _numbers(value, place.key(key)).items()}
        else:
            out[key] = number(value, place.key(key), "the mechanism file's unit")
    return out


def _deviations(entry: Any, place: Place) -> dict[str, float]:
    numbers = _numbers(entry, place)
    for name, sigma in numbers.items():
        if sigma < 0.0:
            raise place.key(name).error(f"found {sigma:.9g}; a standard deviation is 0 or above")
    return numbers


def _load_mode(entry: Mapping[str, Any], place: Place) -> LoadMode:
    refuse_unknown_keys(entry, LOAD_MODE_KEYS, place)
    frequency_hz, inertia = (
        above_zero(required(entry, key, place, f"write {key} = ..."), place.key(key), unit)
        for key, unit in (("frequency_hz", "Hz"), ("inertia", "kg m2"))
    )
    return LoadMode(frequency_hz, required_damping(entry, place, "write damping = ..."), inertia)
