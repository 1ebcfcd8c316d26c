"""BUDGET.toml: the estimate, what flies, the modes of operation, the structure, the requirements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechid.budget.flight_entry import Flight, read_flight
from mechid.budget.requirement import Requirement
from mechid.budget.requirement_entry import read_requirements
from mechid.budget.structure_entry import read_structure_entry
from mechid.campaign.place import Place, found, number, refuse_unknown_keys, required, tables, text
from mechid.campaign.toml_file import read_toml
from mechid.command import Command
from mechid.command.entry import is_table, is_whole
from mechid.command.rate_entry import RATE_KEYS
from mechid.structure import Structure

FloatArray = NDArray[np.float64]

KEYS = ("estimate", "axis", "seed", "flight", "structure", "mode", "requirement")
MODE_KEYS = ("name", "command", "rates", "rate_range", "settle_s", "highest_hz")
RATE_REMEDY = "write rate_range = { from = 10.0, to = 120.0, count = 45 } or rates = [23.0, 46.0]"
SETTLE_S, HIGHEST_HZ = 1.0, 500.0
MOST_RATES = 2000


@dataclass(frozen=True, kw_only=True)
class OperatingMode:
    """A way in which the mechanism is driven, at one rate or at several.

    Parameters
    ----------
    name : str
    command : Command
        Its rate is replaced by each of `rates`.
    rates : (r,)
        Full steps/s, ascending, not zero.
    settle_s : float
        Time from the start until the motion counts as steady.
    highest_hz : float
        Lines above are left out.
    """

    name: str
    command: Command
    rates: FloatArray
    settle_s: float = SETTLE_S
    highest_hz: float = HIGHEST_HZ


@dataclass(frozen=True, kw_only=True)
class BudgetFile:
    """What a budget file asks for, its structure read."""

    path: Path
    estimate: Path
    flight: Flight
    structure: Structure
    coupled_below_hz: float
    modes: tuple[OperatingMode, ...]
    requirements: tuple[Requirement, ...]
    seed: int = 0


def read_budget_file(path: Path | str) -> BudgetFile:
    """Return what a budget file asks for.

    Raises
    ------
    InputFileError
        The file or its structure is missing or wrong; one line with place, what was found and remedy.
    """
    path = Path(path)
    table, place = read_toml(path), Place(path.name)
    refuse_unknown_keys(table, KEYS, place)
    estimate = text(
        required(table, "estimate", place, 'write estimate = "estimate.json", as mechid identify leaves it'),
        place.key("estimate"), 'write the name of a file, as "estimate.json"',
    )  # fmt: skip
    structure, coupled_below_hz = read_structure_entry(table, place, path.parent)
    seed = table.get("seed", 0)
    if not is_whole(seed, 0, 2**32):
        raise place.key("seed").error(f"{found(seed)}; write a whole number from 0")
    return BudgetFile(
        path=path,
        estimate=path.parent / estimate,
        flight=read_flight(table.get("flight", {}), place.key("flight")),
        structure=structure,
        coupled_below_hz=coupled_below_hz,
        modes=_modes(table, place, path.parent),
        requirements=read_requirements(table, place, structure.line_of_sight),
        seed=seed,
    )


def _modes(table: Mapping[str, Any], place: Place, folder: Path) -> tuple[OperatingMode, ...]:
    entries = tables(table.get("mode", []), place.key("mode"))
    if not entries:
        raise place.error("no mode of operation; write one [[mode]] table for each")
    places = [place.key("mode").item(k) for k in range(len(entries))]
    modes = tuple(_mode(entry, at, folder) for entry, at in zip(entries, places, strict=True))
    for k, mode in enumerate(modes):
        if mode.name in [other.name for other in modes[:k]]:
            raise places[k].key("name").error(f'"{mode.name}" is the name of another mode; give each its own')
    return modes


def _mode(entry: Mapping[str, Any], place: Place, folder: Path) -> OperatingMode:
    refuse_unknown_keys(entry, MODE_KEYS, place)
    name = text(required(entry, "name", place, 'write name = "scan"'), place.key("name"), "write a name")
    remedy = 'write command = { stepping = "micro", microsteps = 16, rate = 46.0 }'
    command = required(entry, "command", place, remedy)
    if not is_table(command):
        raise place.key("command").error(f"{found(command)}; {remedy}")
    rates = _rates(entry, command, place)
    steady = {k: v for k, v in command.items() if k not in RATE_KEYS} | {"rate": float(rates[0])}
    return OperatingMode(
        name=name,
        command=Command.from_table(steady, str(place.key("command")), folder),
        rates=rates,
        settle_s=_positive(entry, "settle_s", SETTLE_S, place, "s"),
        highest_hz=_positive(entry, "highest_hz", HIGHEST_HZ, place, "Hz"),
    )


def _rates(entry: Mapping[str, Any], command: Mapping[str, Any], place: Place) -> FloatArray:
    """Return the rates of a mode: of its command, or of one of the two keys beside it."""
    given = [key for key in ("rates", "rate_range") if key in entry]
    for key in RATE_KEYS[1:]:
        if key in command:
            raise place.key("command").key(key).error(f"a budget is made of steady rates; {RATE_REMEDY}")
    if len(given) + ("rate" in command) != 1:
        raise place.error(f"found {len(given) + ('rate' in command)} of command.rate, rates, rate_range; keep one")
    if not given:
        return _checked(np.array([number(command["rate"], place.key("command").key("rate"), "full steps/s")]), place)
    at = place.key(given[0])
    if given[0] == "rates":
        listed = entry["rates"]
        if not isinstance(listed, list) or not listed:
            raise at.error(f"{found(listed)}; write rates = [23.0, 46.0]")
        numbers = [number(rate, at.item(k), "full steps/s") for k, rate in enumerate(listed)]
        return _checked(np.unique(np.array(numbers)), at)
    return _checked(_range(entry["rate_range"], at), at)


def _range(entry: Any, place: Place) -> FloatArray:
    if not is_table(entry):
        raise place.error(f"{found(entry)}; {RATE_REMEDY}")
    refuse_unknown_keys(entry, ("from", "to", "count"), place)
    low, high = (number(required(entry, k, place, RATE_REMEDY), place.key(k), "full steps/s") for k in ("from", "to"))
    count = entry.get("count", 0)
    if not is_whole(count, 2, MOST_RATES) or low >= high:
        raise place.error(f"found {low:.9g} to {high:.9g} in {count}; {RATE_REMEDY}")
    return np.linspace(low, high, count)


def _checked(rates: FloatArray, place: Place) -> FloatArray:
    if np.any(rates <= 0.0):
        raise place.error(f"found {rates.min():.9g}; a steady rate is above 0 full steps/s")
    return rates


def _positive(entry: Mapping[str, Any], key: str, default: float, place: Place, unit: str) -> float:
    value = number(entry.get(key, default), place.key(key), unit)
    if value <= 0.0:
        raise place.key(key).error(f"found {value:.9g}; write a number above 0 in {unit}")
    return value
