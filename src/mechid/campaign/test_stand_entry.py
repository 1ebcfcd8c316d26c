"""The ``test_stand`` of a record: values of the test stand that are its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from mechid.campaign.campaign import CampaignRecord, record_parameter_name
from mechid.campaign.mechanism_structure import divisors
from mechid.campaign.parameter_entry import read_parameter
from mechid.campaign.place import Place, found, refuse_unknown_keys
from mechid.command.entry import is_table
from mechid.parameter import Parameter
from mechid.plant.mechanism import Mechanism
from mechid.plant.tables import OF_RECORD

KEY = "test_stand"
EXAMPLE = "{ transducer.gain = { value = 1.0, min = 0.8, max = 1.2 } }"


def with_test_stands(
    records: tuple[CampaignRecord, ...], entries: list[Mapping[str, Any]], mechanism: Mechanism, place: Place
) -> tuple[CampaignRecord, ...]:
    """Return the records with the parameters that their ``test_stand`` gives them of their own.

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
        A parameter is none of the mechanism's test stand, or its value or bounds cannot be.
    """
    return tuple(
        replace(record, parameters=(*record.parameters, *_own(record, entry[KEY], mechanism, at.key(KEY))))
        if KEY in entry
        else record
        for record, entry, at in zip(records, entries, _places(place, len(records)), strict=True)
    )


def _places(place: Place, count: int) -> list[Place]:
    return [place.key("record").item(index) for index in range(count)]


def _own(record: CampaignRecord, entry: Any, mechanism: Mechanism, place: Place) -> list[Parameter]:
    if not is_table(entry):
        raise place.error(f"{found(entry)}; write a table, as {EXAMPLE}")
    declared = {
        name: mechanism.plant.declarations[name]
        for name in mechanism.plant.of_record.values()
        if name.partition(".")[0] in OF_RECORD
    }
    there = {name.partition(".")[0] for name in declared}
    for table in entry:
        if table in OF_RECORD and table not in there:
            raise place.key(table).error(f"the mechanism has none; write [{table}] in its file")
    refuse_unknown_keys(entry, tuple(sorted(there)), place)
    dividing, parameters = divisors(mechanism.plant), []
    for table, own in entry.items():
        if not is_table(own):
            raise place.key(table).error(f"{found(own)}; write a table, as {EXAMPLE}")
        keys = [name.partition(".")[2] for name in declared if name.partition(".")[0] == table]
        refuse_unknown_keys(own, keys, place.key(table))
        for key, value in own.items():
            name, at = f"{table}.{key}", place.key(table).key(key)
            full = record_parameter_name(record.name, name)
            parameter = read_parameter(value, full, declared[name], at, divides=name in dividing)
            parameters.append(replace(parameter, replaces=name))
    return parameters
