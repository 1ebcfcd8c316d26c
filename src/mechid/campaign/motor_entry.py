"""Values of the motor that a record has of its own: its supply, and the resistance of its windings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from mechid.campaign.campaign import record_parameter_name
from mechid.campaign.mechanism_structure import divisors
from mechid.campaign.parameter_entry import read_parameter
from mechid.campaign.place import Place
from mechid.parameter import Parameter
from mechid.plant.mechanism import Mechanism
from mechid.plant.tables import MOTOR_OF_RECORD


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
