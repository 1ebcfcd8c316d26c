"""Sections on dependence: correlation of the estimates, information by record and by channel."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from mechid.ink.document import IN_DOCUMENTS, Rows, Section, Words
from mechid.ink.quantities import quantity_words
from mechid.reports.tables import matrix

BY_RECORD = (
    "Share of a record in what is known of a parameter, in percent, all others held (residuals counted as white)."
)
FACTORS = "Factor on a standard error if the record were missing; below, if it were there twice."
BY_CHANNEL = (
    "Share of a channel, over all records, in what is known of a parameter, in percent, all others held; below, the "
    "factor on a standard error if it were not measured."
)


def dependence_section(data: Mapping[str, Any]) -> Section:
    """Return the section from the result of `report_contents`."""
    correlation, information = data["correlation"], data["information"]
    parts = [*_correlation(correlation), *(_information(information) if information else ())]
    return Section("Dependence and information", parts, "dependence", "Dependence", where=IN_DOCUMENTS)


def _correlation(correlation: Mapping[str, Any]) -> Iterator[Section]:
    names, symbols = correlation["names"], correlation["symbols"]
    texts = [["1" if i == j else text for j, text in enumerate(row)] for i, row in enumerate(correlation["text"])]
    # The diagonal is 1 by definition; shaded, it would outshine the other entries.
    shades = [[0.0 if i == j else v for j, v in enumerate(row)] for i, row in enumerate(correlation["matrix"])]
    if names:
        yield Section("Correlation of the estimates", (Rows(matrix("", names, symbols, texts, shades)),))


def _information(found: Mapping[str, Any]) -> Iterator[Section]:
    names, texts, records = found["parameters"], found["text"], found["records"]
    shares = Rows(matrix("", names, records, texts["share_percent"], _of_one(found["share_percent"])))
    factors = [Rows(matrix(key, names, records, texts[key])) for key in ("without", "repeated")]
    yield Section("Information by record", (Words(BY_RECORD), shares, Words(FACTORS), *factors))
    if len(found["channels"]) > 1:
        channels = [quantity_words(quantity) for quantity in found["channels"]]
        shades = _of_one(found["channel_share_percent"])
        shares = Rows(matrix("", names, channels, texts["channel_share_percent"], shades))
        without = Rows(matrix("without", names, channels, texts["without_channel"]))
        yield Section("What each channel adds", (Words(BY_CHANNEL), shares, without))


def _of_one(percent: Sequence[Sequence[float]]) -> list[list[float]]:
    return [[0.01 * value for value in row] for row in percent]
