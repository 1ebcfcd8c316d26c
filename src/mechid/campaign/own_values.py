"""Values of the mechanism that a record has of its own: of its motor, and of its test stand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from mechid.campaign.campaign import CampaignRecord, record_parameter_name
from mechid.campaign.mechanism_structure import divisors
from mechid.campaign.parameter_entry import read_parameter
from mechid.campaign.place import Place
from mechid.campaign.test_stand_entry import stand_values
from mechid.parameter import Parameter
from mechid.plant.mechanism import Mechanism
from mechid.plant.tables import MOTOR_OF_RECORD


def with_own_values(
    records: Sequence[CampaignRecord],
    entries: Sequence[Mapping[str, Any]],
    places: Sequence[Place],
    mechanism: Mechanism,
) -> tuple[CampaignRecord, ...]:
    """Return the records with the values that their tables give of the mechanism for them alone.

    Parameters
    ----------
    records : sequence of CampaignRecord
    entries : sequence of Mapping
        Their tables in the campaign file.
    places : sequence of Place
        Of these.
    mechanism : Mechanism

    Raises
    ------
    InputFileError
        The mechanism has no such parameter, or its value or bounds cannot be.
    """
    return tuple(
        replace(record, parameters=(*record.parameters, *_own(record.name, entry, mechanism, at)))
        for record, entry, at in zip(records, entries, places, strict=True)
    )


def motor_values(record: str, entry: Mapping[str, Any], mechanism: Mechanism, place: Place) -> Iterator[Parameter]:
    """Yield the values that a record's table gives of the motor for it alone, as ``peak_voltage``.

    Raises
    ------
    InputFileError
        The mechanism has no such parameter, or its value or bounds cannot be.
    """
    for key in (key for key in MOTOR_OF_RECORD if key in entry):
        name = mechanism.plant.of_record.get(key)
        if name is None:
            raise place.key(key).error("the mechanism has no such parameter; leave it out")
        parameter = read_parameter(
            entry[key],
            record_parameter_name(record, key),
            mechanism.plant.declarations[name],
            place.key(key),
            divides=name in divisors(mechanism.plant),
        )
        yield replace(parameter, replaces=name)


def _own(record: str, entry: Mapping[str, Any], mechanism: Mechanism, place: Place) -> Iterator[Parameter]:
    yield from motor_values(record, entry, mechanism, place)
    yield from stand_values(record, entry, mechanism, place)
