"""The ``[bench]`` table of a campaign: how the mechanism stands on a table that measures more than its torque."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from mechid.campaign.campaign import CampaignRecord
from mechid.campaign.place import Place, found, number, one_of, refuse_unknown_keys, required
from mechid.command.entry import is_table
from mechid.records import Mounting, Record, Role, move_to_mounting_point
from mechid.records.components import AXES, TORQUE

KEY = "bench"
KEYS = ("drive_axis", "mounting_point_m")
DRIVE_AXES = (*AXES, *(f"-{axis}" for axis in AXES))
EXAMPLE = 'write [bench] with drive_axis = "z" and mounting_point_m = [0.0, 0.0, 0.05]'


def read_bench(table: Mapping[str, Any], place: Place, records: Sequence[CampaignRecord]) -> Mounting | None:
    """Return how the mechanism stands on the table; None where no record has a component beside its torque.

    Raises
    ------
    InputFileError
        The entry is missing although a record has such components, or is wrong; a component is the drive torque itself;
        or what it takes to move one to the mounting point is not recorded.
    """
    mounting = _mounting(table[KEY], place.key(KEY)) if KEY in table else None
    for index, record in enumerate(records):
        _check(record, mounting, place.key("record").item(index).key("channels"))
    _refuse_different(records, place.key("record"))
    return mounting


def with_data(record: CampaignRecord, data: Record, mounting: Mounting | None) -> CampaignRecord:
    """Return a record of the campaign with its samples, moments about the mounting point."""
    return replace(record, data=data if mounting is None else move_to_mounting_point(data, mounting))


def _mounting(entry: Any, place: Place) -> Mounting:
    if not is_table(entry):
        raise place.error(f"{found(entry)}; {EXAMPLE}")
    refuse_unknown_keys(entry, KEYS, place)
    axis = one_of(required(entry, KEYS[0], place, 'write drive_axis = "z"'), DRIVE_AXES, place.key(KEYS[0]))
    at, remedy = place.key(KEYS[1]), "write three numbers in m, from the table's reference point: [0.0, 0.0, 0.05]"
    point = required(entry, KEYS[1], place, remedy)
    if not isinstance(point, list) or len(point) != 3:
        raise at.error(f"{found(point)}; {remedy}")
    x, y, z = (number(value, at.item(k), "m") for k, value in enumerate(point))
    return Mounting(axis, (x, y, z))


def _side(record: CampaignRecord) -> list[str]:
    return [channel.quantity for channel in record.spec.channels if channel.role is Role.SIDE]


def _refuse_different(records: Sequence[CampaignRecord], place: Place) -> None:
    """Refuse records of different components: their lines are joined over the rate."""
    having = [(index, _side(record)) for index, record in enumerate(records) if _side(record)]
    for index, own in having:
        if other := sorted(set(own) ^ set(having[0][1])):
            remedy = "give the same in each record that has any"
            raise (
                place.item(index)
                .key("channels")
                .error(f"{', '.join(other)} in one of it and record[{having[0][0]}] alone; {remedy}")
            )


def _check(record: CampaignRecord, mounting: Mounting | None, place: Place) -> None:
    """Refuse components that cannot be told from the drive torque, or cannot be moved to the mounting point."""
    quantities = tuple(channel.quantity for channel in record.spec.channels)
    side = _side(record)
    if not side:
        return
    at = place.item(quantities.index(side[0]))
    if mounting is None:
        raise at.error(f"{side[0]} needs the frame of the table and the mounting point in it; {EXAMPLE}")
    outputs = [channel.quantity for channel in record.spec.channels if channel.role is Role.OUTPUT]
    if TORQUE not in outputs:
        raise at.error(f"{side[0]} is measured with its phase to the drive torque; add a channel of the torque")
    if mounting.drive_moment in side:
        here = place.item(quantities.index(mounting.drive_moment))
        raise here.error(f'{mounting.drive_moment} is the drive torque; write quantity = "torque"')
    for quantity, forces in mounting.levers(quantities):
        if missing := [force for force in forces if force not in side]:
            needs = f"{quantity} about the mounting point takes {' and '.join(missing)} too"
            remedy = "add the channel, or leave this one out" if quantity != TORQUE else "add the channel"
            raise place.item(quantities.index(quantity)).error(f"{needs}, by the lever arm of [bench]; {remedy}")
