"""Records and mechanism joined: which quantity is matched, and which measured channels drive the plant."""

from __future__ import annotations

from dataclasses import replace

from mechid.campaign.campaign import CampaignRecord
from mechid.campaign.channel_entry import TORQUE
from mechid.campaign.place import Place
from mechid.command.measured import InputChannel, MeasuredCommand
from mechid.plant.drive import measured_quantities
from mechid.plant.mechanism import Mechanism
from mechid.records import Record, Role


def joined(
    mechanism: Mechanism, records: tuple[CampaignRecord, ...], place: Place
) -> tuple[Mechanism, tuple[CampaignRecord, ...]]:
    """Return the mechanism that measures what the records hold, and the records that know of what they are.

    All records are matched in one quantity: torque where all have it and the mechanism gives it, else the first
    that the mechanism gives and all records have.

    Parameters
    ----------
    mechanism : Mechanism
    records : tuple of CampaignRecord
    place : Place
        Of the campaign file.

    Raises
    ------
    InputFileError
        A record lacks an input of the mechanism, has one too many, or there is no such quantity.
    """
    plant = mechanism.plant
    for index, record in enumerate(records):
        _refuse_other_inputs(record, measured_quantities(plant.inputs), place.key("record").item(index), plant.name)
    measured = [_outputs(record) for record in records]
    common = [quantity for quantity in plant.offered if all(quantity in own for own in measured)]
    quantity = TORQUE if TORQUE in common else next(iter(common), None)
    if quantity is None:
        raise _nothing_common(measured, tuple(plant.offered), place)
    if tuple(plant.outputs) != (quantity,):
        mechanism = replace(mechanism, plant=plant.measuring((quantity,)))
    return mechanism, tuple(replace(record, quantity=quantity) for record in records)


def with_inputs(record: CampaignRecord, data: Record, mechanism: Mechanism) -> CampaignRecord:
    """Return a record whose command holds the channels that drive it; other records as they are."""
    if not isinstance(record.command, MeasuredCommand):
        return record
    held = {channel.quantity for channel in record.spec.channels if channel.held}
    channels = tuple(
        InputChannel(quantity=q, held=q in held, samples=next(c.data for c in data.inputs if c.quantity == q))
        for q in measured_quantities(mechanism.plant.inputs)
    )
    return replace(record, command=record.command.driven_by(channels, data.sample_rate_hz, data.time_start_s))


def _outputs(record: CampaignRecord) -> list[str]:
    return [c.quantity for c in record.spec.channels if c.role is Role.OUTPUT] or [TORQUE]


def _inputs(record: CampaignRecord) -> list[str]:
    return [c.quantity for c in record.spec.channels if c.role is Role.INPUT]


def _refuse_other_inputs(record: CampaignRecord, needed: tuple[str, ...], place: Place, assembly: str) -> None:
    own = _inputs(record)
    for quantity in needed:
        if quantity not in own:
            entry = f'{{ quantity = "{quantity}", column = "...", role = "input" }}'
            raise place.key("channels").error(f"no {quantity}; it drives the mechanism ({assembly}): add {entry}")
    for at, channel in enumerate(record.spec.channels):
        if channel.role is Role.INPUT and channel.quantity not in needed:
            what = f"driven by {' and '.join(needed)}" if needed else "driven by the command of the steps"
            where = place.key("channels").item(at).key("role")
            raise where.error(f'found "input"; the mechanism ({assembly}) is {what}: leave it out')


def _nothing_common(measured: list[list[str]], offered: tuple[str, ...], place: Place) -> Exception:
    for index, own in enumerate(measured):
        if not set(own) & set(offered):
            where = place.key("record").item(index).key("channels")
            return where.error(f"{', '.join(own)}: the mechanism gives {', '.join(offered)}; name a channel of these")
    return place.key("record").error("no quantity is measured in all records; give each a channel of the same one")
