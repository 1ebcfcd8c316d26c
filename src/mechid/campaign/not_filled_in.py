"""What of the files that ``mechid new`` writes has not been filled in: they say so themselves, and are refused.

A mechanism whose numbers are those of the example may be the example's: the paper's own bench is. So new files carry
marks that stand for "not filled in" rather than being compared with the example: a record's empty command, and
the key `TEMPLATE` of the mechanism.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.place import Place, flag
from mechid.campaign.toml_file import read_toml
from mechid.command.entry import is_table
from mechid.errors import InputFileError

TEMPLATE = "template"
EXAMPLE_COMMAND = '{ stepping = "full", rate = 46.0, start_angle_deg = 0.0 }'


def refuse_empty_commands(table: Mapping[str, Any], place: Place, mechanism_path: Path) -> None:
    """Refuse a campaign in which records have no command yet; what is left of its mechanism is said with it.

    Raises
    ------
    InputFileError
        Commands are empty.
    """
    entries = table.get("record", [])
    empty = [
        str(place.key("record").item(index).key("command"))
        for index, entry in enumerate(entries if isinstance(entries, list) else [])
        if is_table(entry) and entry.get("command") == {} and "channels" not in entry
    ]
    if not empty:
        return
    places = ", ".join([empty[0], *(path.removeprefix(f"{place}: ") for path in empty[1:])])
    said = [f"{places}: empty, as mechid new wrote it; write how the record was driven, as {EXAMPLE_COMMAND}"]
    if mechanism_path.is_file():
        mechanism = read_toml(mechanism_path, "mechanism")
        if mechanism.get(TEMPLATE) is True:
            said.append(_left(mechanism, Place(mechanism_path.name)))
    raise InputFileError("; and ".join(said))


def without_template(table: Mapping[str, Any], place: Place) -> Mapping[str, Any]:
    """Return a mechanism's table without the mark of ``mechid new``.

    Raises
    ------
    InputFileError
        The mark says that the numbers are still the example's.
    """
    if TEMPLATE not in table:
        return table
    if flag(table[TEMPLATE], place.key(TEMPLATE)):
        raise InputFileError(_left(table, place))
    return {key: entry for key, entry in table.items() if key != TEMPLATE}


def _left(table: Mapping[str, Any], place: Place) -> str:
    """Say what of a mechanism is still as ``mechid new`` wrote it, and what to do."""
    example, found = dict(_entries(CATALOGUE)), dict(_entries(table))
    same = [name for name, entry in example.items() if found.get(name) == entry]
    here = f"{place.key(TEMPLATE)}: "
    if not same:
        return f"{here}no number is the example's any more; delete this line"
    if len(same) == len(example):
        return (
            f"{here}nothing is filled in, these are the numbers of the example that mechid new writes; write those "
            "of your supplier in their place, then delete this line"
        )
    return (
        f"{here}still as mechid new wrote them: {', '.join(same)}; write your supplier's numbers in their place, and "
        "when those that are left are right as they are, delete this line"
    )


def _entries(entry: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the numbers of a mechanism file by dotted name, that of one to be estimated with its bounds."""
    parts: Iterator[tuple[Any, Any]] = iter(())
    if is_table(entry) and "value" not in entry:
        parts = iter(entry.items())
    elif isinstance(entry, list):
        parts = enumerate(entry)
    else:
        yield name, entry
    for key, part in parts:
        yield from _entries(part, f"{name}.{key}" if name else str(key))
