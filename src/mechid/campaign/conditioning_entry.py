"""``conditioning`` entry of a record: the preprocessing of its samples."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

from mechid.campaign.place import Place, describe_entry, number, one_of, refuse_unknown_keys
from mechid.command.entry import is_table, is_whole
from mechid.records import Conditioning, TimeStamps

KEYS = ("time_stamps", "limits", "max_gap_s", "cumulate", "quiet_s", "window_s", "decimate")
MOST_DECIMATED = 1000
Pair = tuple[float, float]
Entry = TypeVar("Entry")


def read_conditioning(entry: Any, place: Place, quantities: Sequence[str]) -> Conditioning:
    """Read the conditioning of a record; the default if there is no such entry.

    Parameters
    ----------
    entry : object
        Value of ``conditioning``.
    place : Place
    quantities : sequence of str
        Quantities of the record's channels.

    Raises
    ------
    InputFileError
        A key or value is invalid.
    """
    if entry is None:
        return Conditioning()
    if not is_table(entry):
        raise place.error(f"{describe_entry(entry)}; write a table, as {{ window_s = [0.5, 20.0], decimate = 5 }}")
    refuse_unknown_keys(entry, KEYS, place)
    limits = _by_quantity(entry, place.key("limits"), quantities, lambda value, at: _pair(value, at, "SI units"))
    # Samples at the limits become gaps, which only `max_gap_s` allows to bridge.
    if limits and "max_gap_s" not in entry:
        raise place.key("limits").error(
            "samples on or beyond the limits count as missing; write the longest gap to bridge, max_gap_s = ..."
        )
    return Conditioning(
        time_stamps=TimeStamps(one_of(entry.get("time_stamps", "strict"), tuple(TimeStamps), place.key("time_stamps"))),
        limits=limits,
        max_gap_s=_gap(entry["max_gap_s"], place.key("max_gap_s")) if "max_gap_s" in entry else None,
        cumulate=_quantities(entry.get("cumulate", []), place.key("cumulate"), quantities),
        quiet_s=_by_quantity(entry, place.key("quiet_s"), quantities, _stretches),
        window_s=_pair(entry["window_s"], place.key("window_s"), "s") if "window_s" in entry else None,
        decimate=_factor(entry.get("decimate", 1), place.key("decimate")),
    )


def _by_quantity(
    table: Mapping[str, Any], place: Place, quantities: Sequence[str], read: Callable[[Any, Place], Entry]
) -> dict[str, Entry]:
    """Read a table of entries by quantity."""
    entries = table.get(place.path.rpartition(".")[2], {})
    if not is_table(entries):
        raise place.error(f"{describe_entry(entries)}; write a table by quantity, as {{ torque = ... }}")
    refuse_unknown_keys(entries, quantities, place)
    return {quantity: read(value, place.key(quantity)) for quantity, value in entries.items()}


def _quantities(entry: Any, place: Place, quantities: Sequence[str]) -> tuple[str, ...]:
    if not isinstance(entry, list):
        raise place.error(f'{describe_entry(entry)}; write a list of quantities, as ["rotor_angle"]')
    return tuple(one_of(value, tuple(quantities), place.item(index)) for index, value in enumerate(entry))


def _pair(entry: Any, place: Place, unit: str) -> Pair:
    if not isinstance(entry, list) or len(entry) != 2:
        raise place.error(f"{describe_entry(entry)}; write [from, to] in {unit}")
    low, high = (number(value, place.item(index), unit) for index, value in enumerate(entry))
    if low >= high:
        raise place.error(f"{describe_entry(entry)}; the second has to be above the first")
    return low, high


def _stretches(entry: Any, place: Place) -> tuple[Pair, ...]:
    if not isinstance(entry, list) or not entry:
        raise place.error(f"{describe_entry(entry)}; write a list of stretches, as [[0.0, 0.5]]")
    return tuple(_pair(value, place.item(index), "s") for index, value in enumerate(entry))


def _gap(entry: Any, place: Place) -> float:
    gap = number(entry, place, "s")
    if gap <= 0.0:
        raise place.error(f"{describe_entry(entry)}; write the longest gap to be bridged in s, above 0")
    return gap


def _factor(entry: Any, place: Place) -> int:
    if not is_whole(entry, 1, MOST_DECIMATED):
        raise place.error(f"{describe_entry(entry)}; write a whole number from 1 to {MOST_DECIMATED}")
    return int(entry)
