"""Places in a file, and checks of single entries whose messages begin with the place."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from mechid.command.entry import format_found, is_number, is_table, quote_words
from mechid.errors import InputFileError, did_you_mean


@dataclass(frozen=True)
class Place:
    """A place in a TOML file, e.g. ``campaign.toml: stage[1].free[2]``.

    Parameters
    ----------
    file : str
        Name of the file in messages.
    path : str
        Keys and indices from the top level; empty for the file itself.

    Examples
    --------
    >>> str(Place("campaign.toml").key("stage").item(1).key("free"))
    'campaign.toml: stage[1].free'
    """

    file: str
    path: str = ""

    def __str__(self) -> str:
        return f"{self.file}: {self.path}" if self.path else self.file

    def key(self, name: str) -> Place:
        """Return the place of a key in the table at this place."""
        return Place(self.file, f"{self.path}.{name}" if self.path else name)

    def item(self, index: int) -> Place:
        """Return the place of an item, counted from 0, in the list at this place."""
        return Place(self.file, f"{self.path}[{index}]")

    def error(self, message: str) -> InputFileError:
        """Make an error with this place and `message`."""
        return InputFileError(f"{self}: {message}")


def describe_entry(entry: object) -> str:
    """Return ``found ...`` with the entry in TOML notation."""
    if isinstance(entry, bool):
        return f"found {str(entry).lower()}"
    if is_table(entry):
        return "found a table"
    return "found tables" if is_table_list(entry) and entry else f"found {format_found(entry)}"


def is_table_list(entry: object) -> bool:
    """Return whether the entry is a list of tables only, as ``[[name]]`` makes."""
    return isinstance(entry, list) and all(map(is_table, entry))


def refuse_unknown_keys(table: Iterable[str], known: Sequence[str], place: Place) -> None:
    """Refuse the first key of `table` that is not `known`, and suggest the most similar known key."""
    for key in table:
        if key not in known:
            near = did_you_mean(key, known) or f"; the keys here are {', '.join(known)}"
            raise place.key(key).error(f"unknown key{near}")


def required_entry(table: Mapping[str, Any], key: str, place: Place, remedy: str) -> Any:
    """Return the entry of `key`; if it is missing, refuse with `remedy`."""
    if key not in table:
        raise place.key(key).error(f"missing; {remedy}")
    return table[key]


def text(entry: Any, place: Place, remedy: str) -> str:
    """Return a non-empty string."""
    if not isinstance(entry, str) or not entry:
        raise place.error(f"{describe_entry(entry)}; {remedy}")
    return entry


def flag(entry: Any, place: Place) -> bool:
    """Return a boolean."""
    if not isinstance(entry, bool):
        raise place.error(f"{describe_entry(entry)}; write true or false")
    return entry


def number(entry: Any, place: Place, unit: str) -> float:
    """Return a finite number; `unit` is named in messages."""
    if isinstance(entry, str):
        raise place.error(f"{describe_entry(entry)}; write the number alone{in_unit(unit)}, without quotes")
    if not is_number(entry):
        raise place.error(f"{describe_entry(entry)}; write a finite number{in_unit(unit)}")
    return float(entry)


def positive_number(entry: Any, place: Place, unit: str) -> float:
    """Return a finite number above 0."""
    value = number(entry, place, unit)
    if value <= 0.0:
        raise place.error(f"found {value:.9g}; write a number above 0{in_unit(unit)}")
    return value


def non_negative_number(entry: Any, place: Place, unit: str) -> float:
    """Return a finite number, 0 or above."""
    value = number(entry, place, unit)
    if value < 0.0:
        raise place.error(f"found {value:.9g}; write 0 or above{in_unit(unit)}")
    return value


def one_of(entry: Any, options: Sequence[str], place: Place) -> str:
    """Return the entry if it is one of `options`."""
    if isinstance(entry, str) and entry in options:
        return entry
    near = did_you_mean(entry, options) if isinstance(entry, str) else ""
    raise place.error(f"{describe_entry(entry)}{near or f'; write one of {quote_words(options)}'}")


def texts(entry: Any, place: Place, remedy: str) -> tuple[str, ...]:
    """Return a non-empty list of distinct strings."""
    if not isinstance(entry, list) or not entry:
        raise place.error(f"{describe_entry(entry)}; {remedy}")
    for index, item in enumerate(entry):
        text(item, place.item(index), remedy)
        if item in entry[:index]:
            raise place.item(index).error(f'"{item}" is listed twice; keep one')
    return tuple(entry)


def tables(table: Mapping[str, Any], key: str, place: Place) -> list[tuple[Mapping[str, Any], Place]]:
    """Return the tables of ``[[key]]``, each with its place."""
    entry, here = table.get(key, []), place.key(key)
    if not is_table_list(entry):
        raise here.error(f"{describe_entry(entry)}; write each as a table under [[{here.path}]]")
    return [(one, here.item(k)) for k, one in enumerate(entry)]


def in_unit(unit: str) -> str:
    """Return the unit as ``' in ohm'``, empty for a dimensionless number."""
    return "" if unit == "1" else f" in {unit}"
