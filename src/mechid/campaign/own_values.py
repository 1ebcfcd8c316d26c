"""Values of the mechanism that a record has of its own: of its motor, and of its test stand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from mechid.campaign.campaign import CampaignRecord
from mechid.campaign.motor_entry import motor_values
from mechid.campaign.place import Place
from mechid.campaign.test_stand_entry import stand_values
from mechid.parameter import Parameter
from mechid.plant.mechanism import Mechanism


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


def _own(record: str, entry: Mapping[str, Any], mechanism: Mechanism, place: Place) -> Iterator[Parameter]:
    yield from motor_values(record, entry, mechanism, place)
    yield from stand_values(record, entry, mechanism, place)
