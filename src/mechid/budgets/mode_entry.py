"""Reader of the ``[[mode]]`` tables of a budget file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.operating_mode import RMS_WINDOW_S, SETTLE_S, OperatingMode, usual_highest_hz
from mechid.campaign.place import Place, above_zero, found, number, refuse_unknown_keys, required, tables, text
from mechid.command import Command
from mechid.command.entry import is_table, is_whole
from mechid.command.rate_entry import RATE_KEYS

KEYS = (
    "name",
    "command",
    "rates",
    "rate_range",
    "settle_s",
    "highest_hz",
    "duration_s",
    "rms_window_s",
    "duty",
)
STEADY_KEYS, PROFILE_KEYS = ("rates", "rate_range", "settle_s"), ("duration_s", "rms_window_s")
RATE_REMEDY = "write rate_range = { from = 10.0, to = 120.0, count = 45 } or rates = [23.0, 46.0]"
MOST_RATES, LONGEST_S = 2000, 600.0


def read_modes(table: Mapping[str, Any], place: Place, folder: Path) -> tuple[OperatingMode, ...]:
    """Return the modes of operation, at least one.

    Raises
    ------
    InputFileError
        A key is unknown or missing, an entry wrong, a name used twice, or duties that do not fit together.
    """
    entries = tables(table, "mode", place)
    if not entries:
        raise place.error("no mode of operation; write one [[mode]] table for each")
    places = [at for _, at in entries]
    modes = tuple(_mode(entry, at, folder) for entry, at in entries)
    for k, mode in enumerate(modes):
        if mode.name in [other.name for other in modes[:k]]:
            raise places[k].key("name").error(f'"{mode.name}" is the name of another mode; give each its own')
    _check_duties(modes, places)
    return modes


def _check_duties(modes: Sequence[OperatingMode], places: Sequence[Place]) -> None:
    duties = [mode.duty for mode in modes if mode.duty is not None]
    if not duties:
        return
    for mode, at in zip(modes, places, strict=True):
        if mode.duty is None:
            raise at.key("duty").error(
                "missing; other modes have one: give each its own, 0 for one that does not count"
            )
    # Decimal shares such as 0.7 + 0.2 + 0.1 add to 1 only up to rounding.
    if sum(duties) > 1.0 + 1e-9:
        raise places[-1].key("duty").error(f"found {sum(duties):.9g} over all modes; together they are 1 at most")


def _mode(entry: Mapping[str, Any], place: Place, folder: Path) -> OperatingMode:
    refuse_unknown_keys(entry, KEYS, place)
    name = text(required(entry, "name", place, 'write name = "scan"'), place.key("name"), "write a name")
    remedy = 'write command = { stepping = "micro", microsteps = 16, rate = 46.0 }'
    command = required(entry, "command", place, remedy)
    if not is_table(command):
        raise place.key("command").error(f"{found(command)}; {remedy}")
    profile = any(key in command for key in RATE_KEYS[1:])
    for key in STEADY_KEYS if profile else PROFILE_KEYS:
        if key in entry:
            raise place.key(key).error(f"is of a mode with {'steady rates' if profile else 'a profile'}; leave it out")
    duty = None
    if "duty" in entry:
        duty = number(entry["duty"], place.key("duty"), "1")
        if not 0.0 <= duty <= 1.0:
            raise place.key("duty").error(f"found {duty:.9g}; write a share from 0 to 1")
    if profile:
        driven = Command.from_table(command, str(place.key("command")), folder)
        highest_hz = _highest_hz(entry, driven, float(np.abs(driven.rate.rates).max()), place)
        duration, window = _profile_times(entry, driven, place)
        return OperatingMode(
            name=name,
            command=driven,
            rates=np.zeros(0),
            highest_hz=highest_hz,
            duty=duty,
            duration_s=duration,
            rms_window_s=window,
        )
    rates = _rates(entry, command, place)
    steady = {k: v for k, v in command.items() if k not in RATE_KEYS} | {"rate": float(rates[0])}
    stepped = Command.from_table(steady, str(place.key("command")), folder)
    return OperatingMode(
        name=name,
        command=stepped,
        rates=rates,
        refined="rate_range" in entry,
        settle_s=_positive(entry, "settle_s", SETTLE_S, place, "s"),
        highest_hz=_highest_hz(entry, stepped, float(rates.max()), place),
        duty=duty,
    )


def _highest_hz(entry: Mapping[str, Any], command: Command, highest_rate: float, place: Place) -> float:
    return _positive(entry, "highest_hz", usual_highest_hz(command, highest_rate), place, "Hz")


def _profile_times(entry: Mapping[str, Any], command: Command, place: Place) -> tuple[float, float]:
    last = command.rate.times_s[-1]
    duration = _positive(entry, "duration_s", last, place, "s")
    if duration > LONGEST_S:
        raise place.key("duration_s").error(f"found {duration:.9g}; a profile takes {LONGEST_S:.9g} s at most")
    window = _positive(entry, "rms_window_s", min(RMS_WINDOW_S, duration), place, "s")
    if window > duration:
        raise place.key("rms_window_s").error(f"found {window:.9g}; the profile takes {duration:.9g} s")
    return duration, window


def _rates(entry: Mapping[str, Any], command: Mapping[str, Any], place: Place) -> FloatArray:
    """Return the rates of a steady mode, from its command or from one of the two keys beside it."""
    given = [key for key in ("rates", "rate_range") if key in entry]
    # The three keys exclude one another: a second one would silently replace the first.
    if len(given) + ("rate" in command) != 1:
        raise place.error(
            f"found {len(given) + ('rate' in command)} of command.rate, rates, rate_range; keep one, or give "
            "command.rate_profile"
        )
    if not given:
        return _positive_rates(
            np.array([number(command["rate"], place.key("command").key("rate"), "full steps/s")]), place
        )
    at = place.key(given[0])
    if given[0] == "rates":
        listed = entry["rates"]
        if not isinstance(listed, list) or not listed:
            raise at.error(f"{found(listed)}; write rates = [23.0, 46.0]")
        numbers = [number(rate, at.item(k), "full steps/s") for k, rate in enumerate(listed)]
        return _positive_rates(np.unique(np.array(numbers)), at)
    return _positive_rates(_range(entry["rate_range"], at), at)


def _range(entry: Any, place: Place) -> FloatArray:
    if not is_table(entry):
        raise place.error(f"{found(entry)}; {RATE_REMEDY}")
    refuse_unknown_keys(entry, ("from", "to", "count"), place)
    low, high = (number(required(entry, k, place, RATE_REMEDY), place.key(k), "full steps/s") for k in ("from", "to"))
    count = entry.get("count", 0)
    if not is_whole(count, 2, MOST_RATES) or low >= high:
        raise place.error(
            f"found from {low:.9g} to {high:.9g} in {count} rates; from is below to, "
            f"count a whole number from 2 to {MOST_RATES}"
        )
    return np.linspace(low, high, count)


def _positive_rates(rates: FloatArray, place: Place) -> FloatArray:
    if np.any(rates <= 0.0):
        raise place.error(f"found {rates.min():.9g}; a steady rate is above 0 full steps/s")
    return rates


def _positive(entry: Mapping[str, Any], key: str, default: float, place: Place, unit: str) -> float:
    return above_zero(entry.get(key, default), place.key(key), unit)
