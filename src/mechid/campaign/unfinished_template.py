"""Checks for unfinished templates, the files that ``mechid new`` writes.

Comparison with the example would not do: the numbers of the example are right for the bench of the paper. New files
therefore carry marks that stand for "not filled in": the empty command of a record, and the key `TEMPLATE` of the
mechanism.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mechid.campaign.catalogue_values import CATALOGUE, CATALOGUES
from mechid.campaign.place import Place, flag
from mechid.campaign.toml_file import read_toml
from mechid.command.entry import is_table
from mechid.errors import InputFileError
from mechid.reading.whole import is_file

TEMPLATE = "template"
EXAMPLE_CHANNELS = (
    '[{ quantity = "rotor_rate", column = "..." }, { quantity = "voltage", column = "...", role = "input" }]'
)
EXAMPLE_COMMAND = '{ stepping = "full", rate = 46.0, start_angle_deg = 0.0 }'


def refuse_empty_commands(table: Mapping[str, Any], place: Place, mechanism_path: Path) -> None:
    """Refuse a campaign whose records have no command or channels yet; also name unfinished mechanism entries.

    Raises
    ------
    InputFileError
        A command or a list of channels is empty.
    """
    listed = table.get("record", [])
    entries = [
        (place.key("record").item(index), entry)
        for index, entry in enumerate(listed if isinstance(listed, list) else [])
        if is_table(entry)
    ]
    commands = [at.key("command") for at, entry in entries if entry.get("command") == {} and "channels" not in entry]
    channels = [at.key("channels") for at, entry in entries if entry.get("channels") == [] and "command" not in entry]
    if not (commands or channels):
        return
    problems = [_empty(commands, place, f"how the record was driven, as {EXAMPLE_COMMAND}")] if commands else []
    problems += [_empty(channels, place, f"which column is what, as {EXAMPLE_CHANNELS}")] if channels else []
    if is_file(mechanism_path):
        mechanism = read_toml(mechanism_path, "mechanism")
        if mechanism.get(TEMPLATE) is True:
            problems.append(_unfinished_words(mechanism, Place(mechanism_path.name)))
    raise InputFileError("; and ".join(problems))


def _empty(places: Sequence[Place], file: Place, content: str) -> str:
    first, *others = map(str, places)
    listed = ", ".join([first, *(path.removeprefix(f"{file}: ") for path in others)])
    return f"{listed}: empty, as mechid new wrote it; write {content}"


def without_template(table: Mapping[str, Any], place: Place) -> Mapping[str, Any]:
    """Return the table of a mechanism without the mark of ``mechid new``.

    Raises
    ------
    InputFileError
        The mark declares the numbers as those of the example.
    """
    if TEMPLATE not in table:
        return table
    if flag(table[TEMPLATE], place.key(TEMPLATE)):
        raise InputFileError(_unfinished_words(table, place))
    return {key: entry for key, entry in table.items() if key != TEMPLATE}


def _unfinished_words(table: Mapping[str, Any], place: Place) -> str:
    """Return a message that lists the mechanism entries unchanged since ``mechid new``, with the remedy."""
    example, found = dict(_entries(_example(table))), dict(_entries(table))
    # Entries equal to the example are listed as unfinished; the user may confirm them by deleting the mark.
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


def _example(table: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the example of the table's assembly."""
    assembly = table.get("assembly")
    return CATALOGUES.get(assembly, CATALOGUE) if isinstance(assembly, str) else CATALOGUE


def _entries(entry: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the entries of a mechanism file by dotted name, estimated parameters with their bounds."""
    parts: Iterator[tuple[Any, Any]] = iter(())
    if is_table(entry) and "value" not in entry:
        parts = iter(entry.items())
    elif isinstance(entry, list):
        parts = enumerate(entry)
    else:
        yield name, entry
    for key, part in parts:
        yield from _entries(part, f"{name}.{key}" if name else str(key))
