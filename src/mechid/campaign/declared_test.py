"""Tables ``[article]``, ``[test]`` and ``[[instrument]]`` of a campaign file: statements on the test for its report."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path
from typing import Any

from mechid.campaign.place import Place, describe_entry, refuse_unknown_keys, tables, text, texts
from mechid.command.entry import is_table
from mechid.reading.whole import is_file
from mechid.records.formats import digest_of

ARTICLE, TEST, INSTRUMENT, BENCH = "article", "test", "instrument", "bench"
KEYS = (ARTICLE, TEST, INSTRUMENT)
"""Tables of the campaign file."""
NAME, DEVIATIONS, CALIBRATED, DUE = "name", "deviations", "calibrated", "calibration_due"
ARTICLE_KEYS = (NAME, "part_number", "serial_number", "model", "configuration")
TEST_KEYS = ("reference", "procedure", "date", "place", "set_up", "conditions")
INSTRUMENT_KEYS = (NAME, "serial_number", "measures", "uncertainty", CALIBRATED, DUE, "certificate")
DATES = ("date", CALIBRATED, DUE)
WRITE_TEXT, WRITE_DATE = 'write a text, as "SADM-200"', "write a date, as 2026-03-31"
ISO_DATE = re.compile(r"\d{4}-\d{2}-\d{2}")


@dataclass(frozen=True, kw_only=True)
class DeclaredTest:
    """Statements on a test that no record holds, all of them optional.

    Attributes
    ----------
    article, test : mapping of str to str
        Entries of ``[article]`` and ``[test]``; dates as ``YYYY-MM-DD``.
    deviations : tuple of str
    instruments : tuple of (mapping of str to str)
    bench : mapping
        Entries of ``[bench]`` as written.
    files : mapping of str to str
        SHA-256 of the files that these tables name, by the name as written.
    """

    article: Mapping[str, str] = field(default_factory=dict)
    test: Mapping[str, str] = field(default_factory=dict)
    deviations: tuple[str, ...] = ()
    instruments: tuple[Mapping[str, str], ...] = ()
    bench: Mapping[str, Any] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return the statements as JSON can hold them."""
        return {
            ARTICLE: dict(self.article),
            TEST: dict(self.test),
            DEVIATIONS: list(self.deviations),
            "instruments": [dict(one) for one in self.instruments],
            BENCH: dict(self.bench),
            "files": dict(self.files),
        }


def read_declared_test(table: Mapping[str, Any], place: Place, folder: Path) -> DeclaredTest:
    """Read the statements on the test.

    Parameters
    ----------
    table : mapping
        Content of the campaign file.
    place : Place
        Place of the file, for messages.
    folder : Path
        Base of the names of files.

    Raises
    ------
    InputFileError
        A table or an entry is wrong.
    """
    article = _table(table, ARTICLE, ARTICLE_KEYS, place)
    test, at = _table(table, TEST, (*TEST_KEYS, DEVIATIONS), place), place.key(TEST)
    deviations = texts(test[DEVIATIONS], at.key(DEVIATIONS), 'write ["..."]') if DEVIATIONS in test else ()
    instruments = tuple(_instrument(one, here) for one, here in tables(table, INSTRUMENT, place))
    # `read_bench` refuses a wrong entry in its own words.
    bench = _plain(table[BENCH]) if is_table(table.get(BENCH)) else {}
    named = (name for entry in (bench, [dict(one) for one in instruments]) for name in _texts(entry))
    return DeclaredTest(
        article=_entries(article, ARTICLE_KEYS, place.key(ARTICLE)),
        test=_entries(test, TEST_KEYS, at),
        deviations=deviations,
        instruments=instruments,
        bench=bench,
        files={name: digest_of(folder / name) for name in named if is_file(folder / name)},
    )


def _table(table: Mapping[str, Any], key: str, known: Sequence[str], place: Place) -> Mapping[str, Any]:
    entry = table.get(key, {})
    if not is_table(entry):
        raise place.key(key).error(f"{describe_entry(entry)}; write a table under [{key}]")
    refuse_unknown_keys(entry, known, place.key(key))
    return dict(entry)


def _instrument(table: Mapping[str, Any], place: Place) -> dict[str, str]:
    refuse_unknown_keys(table, INSTRUMENT_KEYS, place)
    one = _entries(table, INSTRUMENT_KEYS, place)
    if not one:
        raise place.key(NAME).error(f"missing; {WRITE_TEXT}")
    if CALIBRATED in one and one.get(DUE, "9999") < one[CALIBRATED]:
        raise place.key(DUE).error(f"{one[DUE]} is before {CALIBRATED}, {one[CALIBRATED]}; correct one of them")
    return one


def _entries(table: Mapping[str, Any], known: Sequence[str], place: Place) -> dict[str, str]:
    if table and NAME in known and NAME not in table:
        raise place.key(NAME).error(f"missing; {WRITE_TEXT}")
    # In the order of the report, not of the file.
    return {key: _entry(table[key], key, place.key(key)) for key in known if key in table}


def _entry(entry: Any, key: str, place: Place) -> str:
    if key not in DATES:
        return text(entry, place, WRITE_TEXT)
    # A date with a time of day is a date in Python as well, and its text is no day.
    found = str(entry) if isinstance(entry, date | str) else ""
    try:
        return date.fromisoformat(found if ISO_DATE.fullmatch(found) else "").isoformat()
    except ValueError:
        raise place.error(f"{describe_entry(found or entry)}; {WRITE_DATE}") from None


def _plain(entry: Any) -> Any:
    """Return an entry with what JSON cannot hold as text."""
    if is_table(entry):
        return {str(key): _plain(value) for key, value in entry.items()}
    if isinstance(entry, list):
        return [_plain(value) for value in entry]
    return entry if isinstance(entry, str | int | float | bool) else str(entry)


def _texts(entry: Any) -> Iterator[str]:
    if isinstance(entry, str):
        yield entry
    elif isinstance(entry, list | Mapping):
        for value in entry.values() if isinstance(entry, Mapping) else entry:
            yield from _texts(value)
