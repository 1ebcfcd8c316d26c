"""``channels`` entry of a record: the columns with their quantities and units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.campaign.campaign import USES, Match
from mechid.campaign.place import (
    Place,
    describe_entry,
    flag,
    is_table_list,
    number,
    one_of,
    refuse_unknown_keys,
    required_entry,
    text,
)
from mechid.command.entry import is_table, is_whole
from mechid.errors import RecordError
from mechid.records import COMPONENTS, ChannelSpec, Role
from mechid.units import SI_UNIT, measures, to_si_factor

KEYS = ("quantity", "column", "unit", "gain", "role", "between")
MATCH_KEYS = ("use", "offset", "drift", "quantisation", "noise_sigma")
BETWEEN = ("linear", "held")
QUANTITIES = tuple(quantity for quantity in SI_UNIT if quantity != "time")
MODELLED = tuple(quantity for quantity in QUANTITIES if quantity not in COMPONENTS)
"""Quantities that a mechanism can output or take as input."""
TORQUE = "torque"
DRIFTING = (TORQUE, "force")
"""Quantities whose transducers drift: offset and drift are projected out by default."""
# A rate or velocity of 0 means rest, so an offset would be a real motion.
RATES = ("rotor_rate", "output_rate", "velocity")
"""Quantities with a true zero: nothing is projected out. For all others, as encoders and probes, the offset is."""
ROLES = (Role.OUTPUT, Role.INPUT)
EXAMPLE = '{ quantity = "torque", column = "Mz" }'
MOST_COLUMNS = 2**31 - 1


def read_channels(entry: Any, place: Place, *, in_volts: bool = False) -> tuple[ChannelSpec, ...]:
    """Read the channels of a record; empty if there is no such entry.

    Parameters
    ----------
    entry : object
        Value of ``channels``.
    place : Place
    in_volts : bool
        Whether torque, forces and moments are voltages, of which the calibration of ``[bench]`` makes loads.

    Raises
    ------
    InputFileError
        A channel is invalid, or none is an output.
    """
    if entry is None:
        return ()
    if not is_table_list(entry) or not entry:
        raise place.error(f"{describe_entry(entry)}; write a list of tables, as [{EXAMPLE}]")
    channels = tuple(_channel(table, place.item(index), in_volts=in_volts) for index, table in enumerate(entry))
    if all(channel.role is not Role.OUTPUT for channel in channels):
        others = "components beside the torque" if any(c.role is Role.SIDE for c in channels) else "inputs"
        raise place.error(f"only {others}; add a channel that the model has to match, as {EXAMPLE}")
    return channels


def read_matches(entry: Any, place: Place, *, own: Mapping[str, bool]) -> tuple[Match, ...]:
    """Read the fit settings of a record's output channels; the torque alone if there is no such entry.

    Parameters
    ----------
    entry : object
        Value of ``channels``, already checked by `read_channels`.
    place : Place
    own : mapping of str to bool
        ``offset`` and ``drift`` of the record, if present; those of a channel take precedence.

    Raises
    ------
    InputFileError
        A setting is invalid, or no channel is used for the estimation.
    """
    if entry is None:
        return (Match(offset=own.get("offset", True), drift=own.get("drift", True)),)
    tables = [(table, place.item(index)) for index, table in enumerate(entry)]
    matches = tuple(_match(table, at, own) for table, at in tables if _role(table, at) is Role.OUTPUT)
    # With nothing to estimate from, the record itself should be declared for validation.
    if all(match.use == "validate" for match in matches):
        raise place.error('use = "validate" in all of them; give one use = "estimate", or the record use = "validate"')
    return matches


def read_time(entry: Any, place: Place) -> ChannelSpec | None:
    """Read the time column of a record; None if there is no such entry.

    Raises
    ------
    InputFileError
        The entry is not a table of ``column`` and optionally ``unit``.
    """
    if entry is None:
        return None
    if not is_table(entry):
        raise place.error(f'{describe_entry(entry)}; write a table, as {{ column = "Time", unit = "ms" }}')
    refuse_unknown_keys(entry, ("column", "unit"), place)
    column = _column(required_entry(entry, "column", place, 'write { column = "Time" }'), place.key("column"))
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
    """Return a positive number in the units of the file, None if the key is missing."""
    if key not in table:
        return None
    size = number(table[key], place.key(key), "the numbers of the file")
    if size <= 0.0:
        raise place.key(key).error(f"found {size:.9g}; write it in the numbers of the file, above 0, or leave it out")
    return size


def _channel(table: Mapping[str, Any], place: Place, *, in_volts: bool) -> ChannelSpec:
    refuse_unknown_keys(table, (*KEYS, *MATCH_KEYS), place)
    quantity = required_entry(table, "quantity", place, 'write what it is, as quantity = "torque"')
    quantity = one_of(quantity, QUANTITIES, place.key("quantity"))
    role = _role(table, place)
    for key in MATCH_KEYS:
        if key in table and role is not Role.OUTPUT:
            kind = "an input" if role is Role.INPUT else "a component that is measured in addition to the torque"
            raise place.key(key).error(f"applies to outputs only, and this is {kind}; leave it out")
    if "between" in table and role is not Role.INPUT:
        raise place.key("between").error('applies to inputs only; add role = "input" to this channel')
    in_volts = in_volts and quantity in (*COMPONENTS, TORQUE)
    return ChannelSpec(
        quantity=quantity,
        column=_column(required_entry(table, "column", place, f"write {EXAMPLE}"), place.key("column")),
        unit=_volts(table, quantity, place.key("unit")) if in_volts else _unit(table, quantity, place.key("unit")),
        gain=_gain(table["gain"], place.key("gain")) if "gain" in table else None,
        role=role,
        held=one_of(table.get("between", "linear"), BETWEEN, place.key("between")) == "held",
        in_volts=in_volts,
    )


def _role(table: Mapping[str, Any], place: Place) -> Role:
    """Return the role of a channel; components of a measuring table are neither outputs nor inputs of the model."""
    if table["quantity"] not in COMPONENTS:
        return Role(one_of(table.get("role", Role.OUTPUT), ROLES, place.key("role")))
    if "role" in table:
        raise place.key("role").error(
            f"{table['quantity']} is measured in addition to the torque and has no role; leave it out"
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
    # The same check as in the readers of records, so that a wrong unit is refused before a file is opened.
    try:
        to_si_factor(unit, quantity)
    except RecordError as error:
        raise place.error(str(error)) from error
    return unit


def _volts(table: Mapping[str, Any], quantity: str, place: Place) -> str:
    """Return the unit of a channel in volts, which has to be stated: numbers of loads look no different."""
    remedy = f'the calibration of [bench] is of voltages, so write the unit of {quantity} as unit = "V"'
    if "unit" not in table:
        raise place.error(f"missing; {remedy}")
    unit = text(table["unit"], place, remedy)
    if not measures(unit, "voltage"):
        raise place.error(f'found "{unit}"; {remedy}, or input_unit = ["N", "N*m"] in the calibration')
    return unit


def _gain(entry: Any, place: Place) -> float:
    gain = number(entry, place, "1")
    if gain == 0.0:
        raise place.error("found 0; it would erase the channel, write -1.0 to reverse its sign")
    return gain
