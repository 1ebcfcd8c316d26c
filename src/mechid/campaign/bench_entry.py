"""``[bench]`` table of a campaign file: mounting of the mechanism on a multi-component measuring table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from mechid.campaign.campaign import CampaignRecord
from mechid.campaign.place import Place, describe_entry, number, one_of, refuse_unknown_keys, required_entry
from mechid.command.entry import is_table
from mechid.records import Mounting, Record, Role, move_to_mounting_point
from mechid.records.components import AXES, TORQUE

KEY = "bench"
KEYS = ("drive_axis", "mounting_point_m")
DRIVE_AXES = (*AXES, *(f"-{axis}" for axis in AXES))
EXAMPLE = 'write [bench] with drive_axis = "z" and mounting_point_m = [0.0, 0.0, 0.05]'


def read_bench(table: Mapping[str, Any], place: Place, records: Sequence[CampaignRecord]) -> Mounting | None:
    """Return the mounting of the mechanism on the table; None if no record has a component besides the torque.

    Raises
    ------
    InputFileError
        The entry is invalid, or missing although a record has such components; a component is the drive torque itself;
        or a force needed to move a moment to the mounting point is not recorded.
    """
    mounting = _mounting(table[KEY], place.key(KEY)) if KEY in table else None
    for index, record in enumerate(records):
        _check(record, mounting, place.key("record").item(index).key("channels"))
    _refuse_different(records, place.key("record"))
    return mounting


def with_data(record: CampaignRecord, data: Record, mounting: Mounting | None) -> CampaignRecord:
    """Attach the samples to a record of the campaign, with moments taken about the mounting point."""
    return replace(record, data=data if mounting is None else move_to_mounting_point(data, mounting))


def _mounting(entry: Any, place: Place) -> Mounting:
    if not is_table(entry):
        raise place.error(f"{describe_entry(entry)}; {EXAMPLE}")
    refuse_unknown_keys(entry, KEYS, place)
    axis = one_of(required_entry(entry, KEYS[0], place, 'write drive_axis = "z"'), DRIVE_AXES, place.key(KEYS[0]))
    at, remedy = place.key(KEYS[1]), "write three numbers in m, from the table's reference point: [0.0, 0.0, 0.05]"
    point = required_entry(entry, KEYS[1], place, remedy)
    if not isinstance(point, list) or len(point) != 3:
        raise at.error(f"{describe_entry(point)}; {remedy}")
    x, y, z = (number(value, at.item(k), "m") for k, value in enumerate(point))
    return Mounting(axis, (x, y, z))


def _side_components(record: CampaignRecord) -> list[str]:
    return [channel.quantity for channel in record.spec.channels if channel.role is Role.SIDE]


def _refuse_different(records: Sequence[CampaignRecord], place: Place) -> None:
    """Refuse records with different components."""
    # The lines of a component are joined over the rate across records, so every record has to contribute to each.
    measured = [(index, side) for index, record in enumerate(records) if (side := _side_components(record))]
    for index, own in measured:
        if other := sorted(set(own) ^ set(measured[0][1])):
            remedy = "give the same in each record that has any"
            raise (
                place.item(index)
                .key("channels")
                .error(f"{', '.join(other)} in one of it and record[{measured[0][0]}] alone; {remedy}")
            )


def _check(record: CampaignRecord, mounting: Mounting | None, place: Place) -> None:
    """Refuse components that duplicate the drive torque or cannot be moved to the mounting point."""
    quantities = tuple(channel.quantity for channel in record.spec.channels)
    side = _side_components(record)
    if not side:
        return
    at = place.item(quantities.index(side[0]))
    if mounting is None:
        raise at.error(f"{side[0]} needs the frame of the table and the mounting point in it; {EXAMPLE}")
    outputs = [channel.quantity for channel in record.spec.channels if channel.role is Role.OUTPUT]
    if TORQUE not in outputs:
        raise at.error(f"{side[0]} is evaluated with its phase relative to the drive torque; add a torque channel")
    if mounting.drive_moment in side:
        here = place.item(quantities.index(mounting.drive_moment))
        raise here.error(f'{mounting.drive_moment} is the drive torque; write quantity = "torque"')
    for quantity, forces in mounting.levers(quantities):
        if missing := [force for force in forces if force not in side]:
            needs = f"{quantity} about the mounting point takes {' and '.join(missing)} too"
            remedy = "add the channel, or leave this one out" if quantity != TORQUE else "add the channel"
            raise place.item(quantities.index(quantity)).error(f"{needs}, by the lever arm of [bench]; {remedy}")
