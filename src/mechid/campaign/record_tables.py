"""Entries for records outside their ``[[record]]`` tables, merged into these tables.

    [[campaign]]
    clock_ppm = -120.0

    [[own]]
    record = "full_46"
    peak_voltage = 5.6

are equivalent to the key ``clock_ppm`` above all records and ``peak_voltage`` in the record of that name. Text appended
to a campaign file cannot set keys of the whole file, or of a record that is not the last, in any other way.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.campaign.campaign import CAMPAIGN, CLOCK, INSTANTS
from mechid.campaign.identify_options import MAINS
from mechid.campaign.place import Place, describe_entry, refuse_unknown_keys, required_entry, tables, text
from mechid.campaign.test_stand_entry import KEY as TEST_STAND
from mechid.campaign.timing_entry import REFERENCE
from mechid.command.entry import is_table
from mechid.errors import did_you_mean
from mechid.plant.tables import MOTOR_OF_RECORD

OWN, RECORD, IDENTIFY = "own", "record", "identify"
REMEDY = 'write the name of its record, as record = "full_46"'
KEYS = (*(declaration.key for declaration in INSTANTS), *MOTOR_OF_RECORD, TEST_STAND)


def merge_tables(table: Mapping[str, Any], place: Place) -> dict[str, Any]:
    """Merge the tables ``[[campaign]]`` and ``[[own]]`` of a campaign file into the tables they extend.

    Raises
    ------
    InputFileError
        An entry is not a table, names no existing record, or repeats a key.
    """
    whole = {key: entry for key, entry in table.items() if key not in (CAMPAIGN, OWN)}
    for entry, at in tables(table, CAMPAIGN, place):
        refuse_unknown_keys(entry, (CLOCK.key, REFERENCE, MAINS), at)
        whole = _merge_keys(whole, {key: value for key, value in entry.items() if key != MAINS}, at)
        if MAINS in entry:
            options = _table(whole, IDENTIFY, place)
            whole[IDENTIFY] = _merge_keys(options, {MAINS: entry[MAINS]}, at)
    records = table.get("record", [])
    if not isinstance(records, list) or not all(map(is_table, records)):
        # Reading the records reports the invalid entry, with its place.
        return whole
    names = [str(record.get("name")) for record in records]
    merged = [dict(record) for record in records]
    for entry, at in tables(table, OWN, place):
        name = text(required_entry(entry, RECORD, at, REMEDY), at.key(RECORD), REMEDY)
        if name not in names:
            near = did_you_mean(name, names) or f"; there are {', '.join(names)}"
            raise at.key(RECORD).error(f'no record "{name}"{near}')
        refuse_unknown_keys(entry, (RECORD, *KEYS), at)
        own = {key: value for key, value in entry.items() if key != RECORD}
        merged[names.index(name)] = _merge_keys(merged[names.index(name)], own, at)
    return {**whole, "record": merged} if merged else whole


def _table(table: Mapping[str, Any], key: str, place: Place) -> Mapping[str, Any]:
    entry = table.get(key, {})
    if not is_table(entry):
        raise place.key(key).error(f"{describe_entry(entry)}; write a table, [{key}]")
    return dict(entry)


def _merge_keys(table: Mapping[str, Any], more: Mapping[str, Any], place: Place) -> dict[str, Any]:
    for key in more:
        if key in table:
            raise place.key(key).error("it is written elsewhere in the file too; keep one of the two")
    return {**table, **more}
