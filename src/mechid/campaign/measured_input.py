"""Assignment of measured channels to the outputs and inputs of the mechanism."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from mechid.campaign.campaign import CampaignRecord, Match
from mechid.campaign.channel_entry import TORQUE
from mechid.campaign.place import Place
from mechid.command.measured import InputChannel, MeasuredCommand
from mechid.plant.drive import measured_quantities
from mechid.plant.mechanism import Mechanism
from mechid.records import Record, Role


def assign_channels(
    mechanism: Mechanism, records: tuple[CampaignRecord, ...], place: Place
) -> tuple[Mechanism, tuple[CampaignRecord, ...]]:
    """Set the outputs of the mechanism to the recorded quantities, and order the matches of the records alike.

    The mechanism outputs each quantity that it offers and that any record holds, the torque first. Each record keeps
    the matches whose quantity is among these outputs.

    Parameters
    ----------
    mechanism : Mechanism
    records : tuple of CampaignRecord
    place : Place
        Place of the campaign file.

    Raises
    ------
    InputFileError
        A record lacks an input of the mechanism, has a surplus one, or holds no output of the mechanism.
    """
    plant = mechanism.plant
    for index, record in enumerate(records):
        _refuse_other_inputs(record, measured_quantities(plant.inputs), place.key("record").item(index), plant.name)
        _refuse_no_output(record, tuple(plant.offered), place.key("record").item(index))
    held = {match.quantity for record in records for match in record.matches}
    # The torque comes first, as the leading channel.
    order = sorted((quantity for quantity in plant.offered if quantity in held), key=lambda q: q != TORQUE)
    if list(plant.outputs) != order:
        mechanism = replace(mechanism, plant=plant.with_outputs(order))
    return mechanism, tuple(replace(record, matches=_in_order(record, order)) for record in records)


def _in_order(record: CampaignRecord, order: Sequence[str]) -> tuple[Match, ...]:
    """Return the matches of a record that the mechanism outputs, in the order of its outputs."""
    own = {match.quantity: match for match in record.matches}
    return tuple(own[quantity] for quantity in order if quantity in own)


def with_inputs(record: CampaignRecord, data: Record, mechanism: Mechanism) -> CampaignRecord:
    """Add the measured inputs to the command of a record; leave records with a step command unchanged."""
    if not isinstance(record.command, MeasuredCommand):
        return record
    held = {channel.quantity for channel in record.spec.channels if channel.held}
    channels = tuple(
        InputChannel(quantity=q, held=q in held, samples=next(c.data[:] for c in data.inputs if c.quantity == q))
        for q in measured_quantities(mechanism.plant.inputs)
    )
    return replace(record, command=record.command.driven_by(channels, data.sample_rate_hz, data.time_start_s))


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
            drive = f"driven by {' and '.join(needed)}" if needed else "driven by the command of the steps"
            where = place.key("channels").item(at).key("role")
            raise where.error(f'found "input"; the mechanism ({assembly}) is {drive}: leave it out')


def _refuse_no_output(record: CampaignRecord, offered: tuple[str, ...], place: Place) -> None:
    """Refuse a record without an estimated channel that the mechanism outputs."""
    own = [match.quantity for match in record.estimated]
    if not set(own) & set(offered):
        given = ", ".join(offered)
        raise place.key("channels").error(f"{', '.join(own)}: the mechanism gives {given}; name a channel of these")
