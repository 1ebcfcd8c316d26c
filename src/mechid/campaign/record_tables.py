"""Entries for records outside their ``[[record]]`` tables, merged into these.

    [[campaign]]
    clock_ppm = -120.0

    [[own]]
    record = "full_46"
    peak_voltage = 5.6

are the keys ``clock_ppm`` above all records and ``peak_voltage`` in the record of that name. Below the last record no
key of the whole file, and none of another record, can be written otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.campaign.campaign import CAMPAIGN, CLOCK, INSTANTS
from mechid.campaign.identify_options import MAINS
from mechid.campaign.place import Place, found, refuse_unknown_keys, required, tables, text
from mechid.campaign.test_stand_entry import KEY as TEST_STAND
from mechid.campaign.timing_entry import REFERENCE
from mechid.command.entry import is_table
from mechid.errors import did_you_mean
from mechid.plant.tables import MOTOR_OF_RECORD

OWN, RECORD, IDENTIFY = "own", "record", "identify"
REMEDY = 'write the name of its record, as record = "full_46"'
KEYS = (*(declaration.key for declaration in INSTANTS), *MOTOR_OF_RECORD, TEST_STAND)


def gathered(table: Mapping[str, Any], place: Place) -> dict[str, Any]:
    """Return the content of a campaign file with its tables ``[[campaign]]`` and ``[[own]]`` where they belong.

    Raises
    ------
    InputFileError
        One of them is no table, names no record, or says what is said elsewhere.
    """
    whole = {key: entry for key, entry in table.items() if key not in (CAMPAIGN, OWN)}
    for entry, at in tables(table, CAMPAIGN, place):
        refuse_unknown_keys(entry, (CLOCK.key, REFERENCE, MAINS), at)
        whole = _joined(whole, {key: value for key, value in entry.items() if key != MAINS}, at)
        if MAINS in entry:
            options = _table(whole, IDENTIFY, place)
            whole[IDENTIFY] = _joined(options, {MAINS: entry[MAINS]}, at)
    records = table.get("record", [])
    if not isinstance(records, list) or not all(map(is_table, records)):
        return whole  # which is refused where records are read
    names = [str(record.get("name")) for record in records]
    joined = [dict(record) for record in records]
    for entry, at in tables(table, OWN, place):
        name = text(required(entry, RECORD, at, REMEDY), at.key(RECORD), REMEDY)
        if name not in names:
            near = did_you_mean(name, names) or f"; there are {', '.join(names)}"
            raise at.key(RECORD).error(f'no record "{name}"{near}')
        refuse_unknown_keys(entry, (RECORD, *KEYS), at)
        own = {key: value for key, value in entry.items() if key != RECORD}
        joined[names.index(name)] = _joined(joined[names.index(name)], own, at)
    return {**whole, "record": joined} if joined else whole


def _table(table: Mapping[str, Any], key: str, place: Place) -> Mapping[str, Any]:
    entry = table.get(key, {})
    if not is_table(entry):
        raise place.key(key).error(f"{found(entry)}; write a table, [{key}]")
    return dict(entry)


def _joined(table: Mapping[str, Any], more: Mapping[str, Any], place: Place) -> dict[str, Any]:
    for key in more:
        if key in table:
            raise place.key(key).error("it is written elsewhere in the file too; keep one of the two")
    return {**table, **more}
