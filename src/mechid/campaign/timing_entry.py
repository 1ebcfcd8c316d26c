"""``clock_ppm`` and ``clock_reference``: how the driver's clock and the recorder's differ, and which is right."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from mechid.campaign.campaign import CAMPAIGN, CLOCK, CampaignRecord, record_parameter_name
from mechid.campaign.parameter_entry import read_parameter
from mechid.campaign.place import Place, one_of
from mechid.command import ClockReference, MeasuredCommand
from mechid.command.timing import CLOCK_REFERENCES

REFERENCE = "clock_reference"

DRIVEN = "the record is driven by its own channels, which are on its own clock; leave it out"


def with_clocks(
    records: tuple[CampaignRecord, ...], table: Mapping[str, Any], place: Place
) -> tuple[CampaignRecord, ...]:
    """Return the records with their clocks: a record's own ``clock_ppm``, else the one above all records.

    That one is a single parameter, ``campaign.clock_ppm``, which all these records share. A record that measured
    channels drive has no clock beside its own.

    Parameters
    ----------
    records : tuple of CampaignRecord
    table : Mapping
        The campaign file.
    place : Place
        Of the file.

    Raises
    ------
    InputFileError
        A value or bound cannot be, or a record has no other clock.
    """
    key, reference = CLOCK.key, read_clock_reference(table, place)
    if reference:
        records = tuple(replace(record, clock_reference=reference) for record in records)
    shared = None
    if key in table:
        shared = read_parameter(table[key], f"{CAMPAIGN}.{key}", CLOCK, place.key(key))
    found = []
    for index, (record, entry) in enumerate(zip(records, table["record"], strict=True)):
        driven, own = isinstance(record.command, MeasuredCommand), shared
        if key in entry:
            at = place.key("record").item(index).key(key)
            if driven:
                raise at.error(DRIVEN)
            own = read_parameter(entry[key], record_parameter_name(record.name, key), CLOCK, at)
        found.append(replace(record, parameters=(*record.parameters, own)) if own and not driven else record)
    return tuple(found)


def read_clock_reference(table: Mapping[str, Any], place: Place) -> ClockReference | None:
    """Return whose clock is right, the driver's or the recorder's; None where the campaign file does not say.

    Raises
    ------
    InputFileError
        It is neither.
    """
    if REFERENCE not in table:
        return None
    found = one_of(table[REFERENCE], CLOCK_REFERENCES, place.key(REFERENCE))
    return next(one for one in CLOCK_REFERENCES if one == found)
