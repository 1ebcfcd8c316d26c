"""Values of the motor that a record has of its own: its supply, and the resistance of its windings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from mechid.campaign.campaign import CampaignRecord, record_parameter_name
from mechid.campaign.mechanism_structure import divisors
from mechid.campaign.parameter_entry import read_parameter
from mechid.campaign.place import Place
from mechid.plant.mechanism import Mechanism
from mechid.plant.tables import MOTOR_OF_RECORD


def with_motors(
    records: tuple[CampaignRecord, ...], entries: list[Mapping[str, Any]], mechanism: Mechanism, place: Place
) -> tuple[CampaignRecord, ...]:
    """Return the records with the values that their tables give of the motor for them alone, as ``peak_voltage``.

    Parameters
    ----------
    records : tuple of CampaignRecord
    entries : list of Mapping
        Their tables in the campaign file.
    mechanism : Mechanism
    place : Place
        Of the campaign file.

    Raises
    ------
    InputFileError
        The mechanism has no such parameter, or its value or bounds cannot be.
    """
    return tuple(
        _with_motor(record, entry, mechanism, place.key("record").item(index))
        for index, (record, entry) in enumerate(zip(records, entries, strict=True))
    )


def _with_motor(record: CampaignRecord, entry: Mapping[str, Any], mechanism: Mechanism, place: Place) -> CampaignRecord:
    own = []
    for key in (key for key in MOTOR_OF_RECORD if key in entry):
        name = mechanism.plant.of_record.get(key)
        if name is None:
            raise place.key(key).error("the mechanism has no such parameter; leave it out")
        parameter = read_parameter(
            entry[key], record_parameter_name(record.name, key), mechanism.plant.declarations[name], place.key(key),
            divides=name in divisors(mechanism.plant),
        )  # fmt: skip
        own.append(replace(parameter, replaces=name))
    return replace(record, parameters=(*record.parameters, *own)) if own else record
