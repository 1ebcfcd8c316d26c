"""Entries ``phases`` and ``connection`` of a mechanism file's ``[stepper]`` table."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any

from mechid.campaign.campaign import CampaignRecord
from mechid.campaign.place import Place, describe_entry, text
from mechid.command.entry import is_table, is_whole, quote_words
from mechid.errors import InputFileError, UsageError
from mechid.plant.mechanism import Mechanism
from mechid.plant.phases import CONNECTION, CONNECTIONS, KEY, STAR, TABLE

SHIFT = "phase_shift_deg"


def read_phases(table: Mapping[str, Any], place: Place) -> int:
    """Return the number of phases of a mechanism file's stepper, 2 unless it says otherwise.

    Raises
    ------
    InputFileError
        The number or the connection is unknown, or they do not go together.
    """
    own = _stepper(table)
    phases, at = own.get(KEY, 2), place.key(f"{TABLE}.{KEY}")
    if not is_whole(phases, min(CONNECTIONS), max(CONNECTIONS)):
        raise at.error(f"{describe_entry(phases)}; write {', '.join(map(str, CONNECTIONS))}")
    usual = CONNECTIONS[phases]
    where = place.key(f"{TABLE}.{CONNECTION}")
    found = text(own.get(CONNECTION, usual), where, f'write {CONNECTION} = "{usual}", or leave it out')
    if found not in CONNECTIONS.values():
        raise where.error(f"{describe_entry(found)}; write one of {quote_words(CONNECTIONS.values())}")
    if found != usual:
        needed = next(n for n, name in CONNECTIONS.items() if name == found)
        raise where.error(
            f'"{found}" is of {needed} phases, the motor has {phases}; write "{usual}", or {KEY} = {needed}'
        )
    if phases == STAR and SHIFT in own:
        raise place.key(f"{TABLE}.{SHIFT}").error("three phases in star are 120 deg apart; leave it out")
    return int(phases)


def with_phases(records: Sequence[CampaignRecord], mechanism: Mechanism, place: Place) -> tuple[CampaignRecord, ...]:
    """Return the records with commands for the phases and the pulses of a mechanism.

    Raises
    ------
    InputFileError
        A command follows a table of two phases and the motor has three, or a step is shorter than a pulse.
    """
    return tuple(_with_phases(one, mechanism, place.key("record").item(k)) for k, one in enumerate(records))


def _with_phases(record: CampaignRecord, mechanism: Mechanism, place: Place) -> CampaignRecord:
    try:
        return replace(record, command=mechanism.command_for(record.command))
    except UsageError as error:
        raise InputFileError(f"{place.key('command')}.{error}") from error


def phase_options(table: Mapping[str, Any], declared: Collection[str]) -> dict[str, str]:
    """Return the two entries that a file has, by dotted name, as texts; none where no stepper is `declared`."""
    own = _stepper(table) if f"{TABLE}.poles" in declared else {}
    return {f"{TABLE}.{key}": str(own[key]) for key in (KEY, CONNECTION) if key in own}


def _stepper(table: Mapping[str, Any]) -> Mapping[str, Any]:
    entry: Any = table.get(TABLE)
    return entry if is_table(entry) else {}
