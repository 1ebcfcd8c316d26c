"""``test_stand`` entry of a record: per-record values of the test stand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from mechid.campaign.campaign import record_parameter_name
from mechid.campaign.mechanism_structure import divisors
from mechid.campaign.parameter_entry import read_parameter
from mechid.campaign.place import Place, describe_entry, refuse_unknown_keys
from mechid.command.entry import is_table
from mechid.parameter import Parameter
from mechid.plant.mechanism import Mechanism
from mechid.plant.tables import OF_RECORD

KEY = "test_stand"
EXAMPLE = "{ transducer.gain = { value = 1.0, min = 0.8, max = 1.2 } }"


def stand_values(record: str, entry: Mapping[str, Any], mechanism: Mechanism, place: Place) -> Iterator[Parameter]:
    """Yield the per-record values of test stand parameters.

    Raises
    ------
    InputFileError
        A parameter does not belong to the test stand of the mechanism, or its value or bounds are impossible.
    """
    if KEY in entry:
        yield from _read_test_stand(record, entry[KEY], mechanism, place.key(KEY))


def _read_test_stand(record: str, entry: Any, mechanism: Mechanism, place: Place) -> Iterator[Parameter]:
    if not is_table(entry):
        raise place.error(f"{describe_entry(entry)}; write a table, as {EXAMPLE}")
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
    dividing = divisors(mechanism.plant)
    for table, own in entry.items():
        if not is_table(own):
            raise place.key(table).error(f"{describe_entry(own)}; write a table, as {EXAMPLE}")
        keys = [name.partition(".")[2] for name in declared if name.partition(".")[0] == table]
        refuse_unknown_keys(own, keys, place.key(table))
        for key, value in own.items():
            name, at = f"{table}.{key}", place.key(table).key(key)
            full = record_parameter_name(record, name)
            parameter = read_parameter(value, full, declared[name], at, divides=name in dividing)
            yield replace(parameter, replaces=name)
