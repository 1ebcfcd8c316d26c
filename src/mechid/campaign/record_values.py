"""Per-record values of mechanism parameters: those of the motor and of the test stand."""

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


def with_record_values(
    records: Sequence[CampaignRecord],
    entries: Sequence[Mapping[str, Any]],
    places: Sequence[Place],
    mechanism: Mechanism,
) -> tuple[CampaignRecord, ...]:
    """Add the per-record values of mechanism parameters to the records.

    Parameters
    ----------
    records : sequence of CampaignRecord
    entries : sequence of Mapping
        Their tables in the campaign file.
    places : sequence of Place
        Places of the tables.
    mechanism : Mechanism

    Raises
    ------
    InputFileError
        The mechanism has no such parameter, or its value or bounds are impossible.
    """
    return tuple(
        replace(record, parameters=(*record.parameters, *_record_values(record.name, entry, mechanism, at)))
        for record, entry, at in zip(records, entries, places, strict=True)
    )


def motor_values(record: str, entry: Mapping[str, Any], mechanism: Mechanism, place: Place) -> Iterator[Parameter]:
    """Yield the per-record values of motor parameters, as ``peak_voltage``.

    Raises
    ------
    InputFileError
        The mechanism has no such parameter, or its value or bounds are impossible.
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


def _record_values(record: str, entry: Mapping[str, Any], mechanism: Mechanism, place: Place) -> Iterator[Parameter]:
    yield from motor_values(record, entry, mechanism, place)
    yield from stand_values(record, entry, mechanism, place)
