"""``clock_ppm`` and ``clock_reference``: difference of the driver's and the recorder's clock, and the true one."""

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
    """Add the clock errors to the records: the ``clock_ppm`` of a record, else that of the campaign.

    The latter is a single parameter, ``campaign.clock_ppm``, shared by these records. A record driven by measured
    channels has only one clock and therefore no clock error.

    Parameters
    ----------
    records : tuple of CampaignRecord
    table : Mapping
        Content of the campaign file.
    place : Place
        Place of the file.

    Raises
    ------
    InputFileError
        A value or bound is impossible, or a record has no second clock.
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
    """Read the clock taken as true, the driver's or the recorder's; None if not declared.

    Raises
    ------
    InputFileError
        The entry is neither of them.
    """
    if REFERENCE not in table:
        return None
    found = one_of(table[REFERENCE], CLOCK_REFERENCES, place.key(REFERENCE))
    return next(one for one in CLOCK_REFERENCES if one == found)
