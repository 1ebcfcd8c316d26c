"""An effect that a fit or a diagnosis names, as reports show it: its values with their texts, and where it belongs."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median
from typing import Any

from mechid.identification.result.missing import Missing, OwnValue
from mechid.ink.digits import with_sigma
from mechid.ink.table import Table
from mechid.ink.text_table import Column, Row

CLEAR = 3.0
"""Standard errors by which a record's value has to differ from the others' to be named; a choice, not measured."""
LEAST_TO_COMPARE = 3
"""Records of which one can be apart from the others."""
CAMPAIGN_FILE, MECHANISM_FILE = "campaign.toml", "mechanism.toml"
NAME = Column("name", "name", words=True)
VALUE = (
    Column("value", "value"),
    Column("std error", "std_error", said="± σ"),
    Column("unit", "unit", words=True),
)


def missing_data(one: Missing) -> dict[str, Any]:
    """Return what the files do not declare and the fit has, with the text of its values."""
    rows = [_row(name, p) for name, p in one.parameters.items()]
    chi_square, share = f"{one.chi_square:.4g}", f"{100.0 * one.share:.3g}"
    file = MECHANISM_FILE if one.block else CAMPAIGN_FILE
    text = {"chi_square": chi_square, "share_percent": share, "apart": _most_apart(one), "file": file}
    text["where"] = _where(one, file)
    return {**one.to_dict(), "rows": rows, "text": text}


def _where(one: Missing, file: str) -> str:
    """Return where the text that declares an effect belongs; one of comments alone has its table in the file."""
    is_comment = all(line.startswith("#") for line in one.toml.splitlines())
    return f"in the table that {file} has already" if is_comment else f"at the end of {file}"


def _most_apart(one: Missing) -> str:
    """Return whose value is furthest from the others', as a sentence's end; empty where no record stands out."""
    own = {n: (p.value, p.std_error) for n, p in one.parameters.items() if n.startswith("record.") and p.std_error}
    if len(own) < LEAST_TO_COMPARE:
        return ""
    middle = median(value for value, _ in own.values())
    apart = {name: abs(value - middle) for name, (value, error) in own.items() if abs(value - middle) >= CLEAR * error}
    if not apart:
        return ""
    name = max(apart, key=lambda name: apart[name])
    value, error = with_sigma(*own[name])
    unit = "" if one.parameters[name].unit == "1" else f" {one.parameters[name].unit}"
    return f", most of all in {name.split('.')[1]}: {value} +- {error}{unit}"


def _row(name: str, p: OwnValue) -> dict[str, Any]:
    """Return a parameter that no table of the mechanism or the campaign has, with the text of its value."""
    value, error = with_sigma(p.value, p.std_error)
    unit = "" if p.unit == "1" else p.unit
    own = {"name": name, "value": p.value, "std_error": p.std_error, "unit": p.unit}
    return {**own, "text": {"value": value, "std_error": error, "unit": unit}}


def own_table(rows: Sequence[Row]) -> Table:
    """Return parameters that no table of the files has, with their values."""
    return Table((NAME, *VALUE), rows)
