"""``[diagnose]`` table of a campaign file: the effects that a diagnosis considers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.campaign.place import Place, describe_entry, refuse_unknown_keys, texts
from mechid.command.entry import is_table

DIAGNOSE = "diagnose"
CONSIDER = "consider"
REMEDY = 'write names of effects as mechid diagnose gives them, as consider = ["stepper.detent:0.9deg", "clock"]'


def read_considered(table: Mapping[str, Any], place: Place) -> tuple[str, ...]:
    """Read the names of the effects that a diagnosis considers; empty for all.

    Raises
    ------
    InputFileError
        The table has another key, or its entry is not a list of texts.
    """
    entry, here = table.get(DIAGNOSE, {}), place.key(DIAGNOSE)
    if not is_table(entry):
        raise here.error(f"{describe_entry(entry)}; write a table, [{DIAGNOSE}]")
    refuse_unknown_keys(entry, (CONSIDER,), here)
    return texts(entry[CONSIDER], here.key(CONSIDER), REMEDY) if CONSIDER in entry else ()
