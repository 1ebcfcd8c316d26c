"""The tables of a diagnosis on a terminal; documents have that of an effect's own values (`fit.tables.own_table`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.ink.table import Table
from mechid.ink.text_table import Column

EFFECTS = (
    Column("effect", "name", words=True),
    Column("chi-square", "chi_square"),
    Column("explains %", "share_percent"),
    Column("records", "records", words=True),
    Column("or else", "aliases", words=True),
)
VALUES = (
    Column("parameter", "name", words=True),
    Column("value", "value"),
    Column("+-", "std_error"),
    Column("unit", "unit", words=True),
)


def effect_table(data: Mapping[str, Any]) -> Table:
    """Return the effects found, and what each explains."""
    return Table(EFFECTS, data["missing"])


def value_table(data: Mapping[str, Any]) -> Table:
    """Return the values of all effects found."""
    return Table(VALUES, [_value(row) for one in data["missing"] for row in one["rows"]])


def _value(row: Mapping[str, Any]) -> dict[str, Any]:
    return {**row, "text": {**row["text"], "name": row["name"]}}
