"""The ``channels`` of a record: which column is which quantity, in which unit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.campaign.campaign import USES, Match
from mechid.campaign.place import (
    Place,
    flag,
    found,
    is_table_list,
    number,
    one_of,
    refuse_unknown_keys,
    required,
    text,
)
from mechid.command.entry import is_table, is_whole
from mechid.errors import RecordError
from mechid.records import COMPONENTS, ChannelSpec, Role
from mechid.units import SI_UNIT, to_si_factor

KEYS = ("quantity", "column", "unit", "gain", "role", "between")
MATCH_KEYS = ("use", "offset", "drift", "quantisation", "noise_sigma")
BETWEEN = ("linear", "held")
QUANTITIES = tuple(quantity for quantity in SI_UNIT if quantity != "time")
MODELLED = tuple(quantity for quantity in QUANTITIES if quantity not in COMPONENTS)
"""Those that a mechanism may give or take."""
TORQUE = "torque"
DRIFTING = (TORQUE, "force")
"""Quantities whose transducers drift: offset and drift are projected out."""
RATES = ("rotor_rate", "output_rate", "velocity")
"""Quantities whose zero is zero: nothing is projected out. Of all others, encoders and probes, the offset is."""
ROLES = (Role.OUTPUT, Role.INPUT)
EXAMPLE = '{ quantity = "torque", column = "Mz" }'
MOST_COLUMNS = 2**31 - 1


def read_channels(entry: Any, place: Place) -> tuple[ChannelSpec, ...]:
    """Return the channels that a record's ``channels`` name; none where there is no such entry.

    Raises
    ------
    InputFileError
        One is wrong, or all of them are inputs.
    """
    if entry is None:
        return ()
    if not is_table_list(entry) or not entry:
        raise place.error(f"{found(entry)}; write a list of tables, as [{EXAMPLE}]")
    channels = tuple(_channel(table, place.item(index)) for index, table in enumerate(entry))
    if all(channel.role is not Role.OUTPUT for channel in channels):
        what = "components beside the torque" if any(c.role is Role.SIDE for c in channels) else "inputs"
        raise place.error(f"nothing but {what}; name what the model is to match: add {EXAMPLE}")
    return channels


def read_matches(entry: Any, place: Place, *, own: Mapping[str, bool]) -> tuple[Match, ...]:
    """Return how the outputs among a record's ``channels`` count; the torque alone where there is no such entry.

    Parameters
    ----------
    entry : object
        What stands under ``channels``, as `read_channels` has found it good.
    place : Place
    own : mapping of str to bool
        The record's own ``offset`` and ``drift``, where it has any; a channel's go before them.

    Raises
    ------
    InputFileError
        One is wrong, or none is to be estimated from.
    """
    if entry is None:
        return (Match(offset=own.get("offset", True), drift=own.get("drift", True)),)
    tables = [(table, place.item(index)) for index, table in enumerate(entry)]
    matches = tuple(_match(table, at, own) for table, at in tables if _role(table, at) is Role.OUTPUT)
    if all(match.use == "validate" for match in matches):
        raise place.error('use = "validate" in all of them; give one use = "estimate", or the record use = "validate"')
    return matches


def read_time(entry: Any, place: Place) -> ChannelSpec | None:
    """Return the time column that a record names; None where there is no such entry.

    Raises
    ------
    InputFileError
        It is no table of ``column`` and perhaps ``unit``.
    """
    if entry is None:
        return None
    if not is_table(entry):
        raise place.error(f'{found(entry)}; write a table, as {{ column = "Time", unit = "ms" }}')
    refuse_unknown_keys(entry, ("column", "unit"), place)
    column = _column(required(entry, "column", place, 'write { column = "Time" }'), place.key("column"))
    return ChannelSpec(quantity="time", column=column, unit=_unit(entry, "time", place.key("unit")))


def _match(table: Mapping[str, Any], place: Place, own: Mapping[str, bool]) -> Match:
    quantity = table["quantity"]
    use = one_of(table.get("use", "estimate"), USES, place.key("use"))
    return Match(
        quantity=quantity,
        use="estimate" if use == "estimate" else "validate",
        offset=flag(table.get("offset", own.get("offset", quantity not in RATES)), place.key("offset")),
        drift=flag(table.get("drift", own.get("drift", quantity in DRIFTING)), place.key("drift")),
        quantisation=_size(table, "quantisation", place) or 0.0,
        noise_sigma=_size(table, "noise_sigma", place),
        offset_assumed="offset" not in table and "offset" not in own,
    )


def _size(table: Mapping[str, Any], key: str, place: Place) -> float | None:
    """Return a size in the file's numbers, None where there is none."""
    if key not in table:
        return None
    size = number(table[key], place.key(key), "the numbers of the file")
    if size <= 0.0:
        raise place.key(key).error(f"found {size:.9g}; write it in the numbers of the file, above 0, or leave it out")
    return size


def _channel(table: Mapping[str, Any], place: Place) -> ChannelSpec:
    refuse_unknown_keys(table, (*KEYS, *MATCH_KEYS), place)
    quantity = required(table, "quantity", place, 'write what it is, as quantity = "torque"')
    quantity = one_of(quantity, QUANTITIES, place.key("quantity"))
    role = _role(table, place)
    for key in MATCH_KEYS:
        if key in table and role is not Role.OUTPUT:
            what = "an input" if role is Role.INPUT else "a component that is measured beside the torque"
            raise place.key(key).error(f"it says how an output is matched, and this is {what}; leave it out")
    if "between" in table and role is not Role.INPUT:
        raise place.key("between").error('it says how an input runs between samples; write role = "input" beside it')
    return ChannelSpec(
        quantity=quantity,
        column=_column(required(table, "column", place, f"write {EXAMPLE}"), place.key("column")),
        unit=_unit(table, quantity, place.key("unit")),
        gain=_gain(table["gain"], place.key("gain")) if "gain" in table else None,
        role=role,
        held=one_of(table.get("between", "linear"), BETWEEN, place.key("between")) == "held",
    )


def _role(table: Mapping[str, Any], place: Place) -> Role:
    """Return what a channel is to the model; a component of a table is no output and no input of it."""
    if table["quantity"] not in COMPONENTS:
        return Role(one_of(table.get("role", Role.OUTPUT), ROLES, place.key("role")))
    if "role" in table:
        raise place.key("role").error(
            f"{table['quantity']} is measured beside the torque and has no role; leave it out"
        )
    return Role.SIDE


def _column(entry: Any, place: Place) -> str | int:
    if is_whole(entry, 0, MOST_COLUMNS):
        return int(entry)
    return text(entry, place, "write the column's name or path, or its index from 0")


def _unit(table: Mapping[str, Any], quantity: str, place: Place) -> str | None:
    if "unit" not in table:
        return None
    unit = text(table["unit"], place, f'write the unit as a text, as unit = "{SI_UNIT[quantity]}"')
    try:
        to_si_factor(unit, quantity)
    except RecordError as error:
        raise place.error(str(error)) from error
    return unit


def _gain(entry: Any, place: Place) -> float:
    gain = number(entry, place, "1")
    if gain == 0.0:
        raise place.error("found 0; it would erase the channel, write -1.0 to reverse its sign")
    return gain
