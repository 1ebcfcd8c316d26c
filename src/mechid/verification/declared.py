"""Sections on what a campaign file declares of its test: article, set-up, instruments, conditions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from mechid.ink.data import Data
from mechid.ink.digits import plain
from mechid.ink.document import Facts, Part, Rows, Words
from mechid.ink.quantities import quantity_words
from mechid.ink.table import Table
from mechid.ink.text_table import Column

NOT_DECLARED = "Not declared in campaign.toml."
MOST_NAMES = 6
"""Most records that are named with a channel."""
LABELS = {
    "name": "name",
    "part_number": "part number",
    "serial_number": "serial number",
    "model": "model",
    "configuration": "configuration",
    "reference": "reference",
    "procedure": "procedure",
    "date": "date",
    "place": "place",
}
"""Words for the keys of ``[article]`` and ``[test]``."""
INSTRUMENTS = (
    Column("instrument", "name", words=True),
    Column("serial number", "serial_number", words=True),
    Column("measures", "measures", words=True),
    Column("uncertainty", "uncertainty", words=True),
    Column("calibrated", "calibrated", words=True),
    Column("calibration due", "calibration_due", words=True),
    Column("certificate", "certificate", words=True),
)
CHANNELS = (
    Column("channel", "quantity", words=True),
    Column("column of the file", "column", words=True),
    Column("unit", "unit", words=True),
    Column("gain", "gain"),
    Column("records", "records", words=True),
)


def article_parts(test: Mapping[str, Any]) -> Iterator[Part]:
    """Yield the test article."""
    article = test.get("article") or {}
    yield Facts([(LABELS[key], value) for key, value in article.items()]) if article else Words(NOT_DECLARED)


def set_up_parts(test: Mapping[str, Any]) -> Iterator[Part]:
    """Yield the set-up in words, and the entries of the measuring table."""
    said = (test.get("test") or {}).get("set_up", "")
    yield Words(said or NOT_DECLARED)
    bench = test.get("bench") or {}
    if bench:
        yield Words("The measuring table, as [bench] of campaign.toml has it:")
        yield Facts([(key.replace("_", " "), value_words(value)) for key, value in bench.items()])


def instrument_parts(test: Mapping[str, Any]) -> Iterator[Part]:
    """Yield the instruments with their calibrations."""
    instruments = test.get("instruments") or []
    if not instruments:
        yield Words(NOT_DECLARED)
        return
    yield Rows(Table(INSTRUMENTS, [{c.key: one.get(c.key, "") for c in INSTRUMENTS} for one in instruments]))


def channel_table(channels: Sequence[Data]) -> Table:
    """Return the channels as declared, `ChannelSpec.to_dict`, each with the names of its ``records``."""
    rows = [
        {
            "quantity": quantity_words(one["quantity"]),
            "column": one["column"],
            "unit": (one["unit"] or "as in the file").replace("*", " "),
            "gain": "" if one["gain"] is None else plain(one["gain"]),
            "records": _names(one["records"]),
        }
        for one in channels
    ]
    return Table(CHANNELS, rows)


def _names(records: Sequence[str]) -> str:
    return ", ".join(records) if len(records) <= MOST_NAMES else f"{len(records)} records"


def condition_parts(test: Mapping[str, Any]) -> Iterator[Part]:
    """Yield the conditions of the test in words."""
    yield Words((test.get("test") or {}).get("conditions", "") or NOT_DECLARED)


def calibration_deviations(test: Mapping[str, Any], day: str) -> Iterator[str]:
    """Yield a sentence on each instrument whose calibration did not cover a day, given as ``YYYY-MM-DD`` or empty."""
    for one in test.get("instruments") or [] if day else []:
        due, calibrated = one.get("calibration_due", ""), one.get("calibrated", "")
        if due and due < day:
            yield f"{one['name']}: its calibration was due on {due}, before the test of {day}."
        if calibrated > day:
            yield f"{one['name']}: it was calibrated on {calibrated}, after the test of {day}."


def value_words(value: Any) -> str:
    """Return an entry of a file in words.

    Examples
    --------
    >>> value_words({"modes_hz": [900.0, 1100.0], "axis": "z"})
    'modes_hz: [900, 1100]; axis: z'
    """
    if isinstance(value, Mapping):
        return "; ".join(f"{key}: {value_words(entry)}" for key, entry in value.items())
    if isinstance(value, list):
        return f"[{', '.join(map(value_words, value))}]"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.9g}" if isinstance(value, float) else str(value)
