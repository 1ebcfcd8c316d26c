"""Presentation of effects named by a fit or a diagnosis: values, texts, and place in the files."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median
from typing import Any

from mechid.identification.result.missing_effects import EffectValue, Missing
from mechid.ink.digits import with_sigma
from mechid.ink.table import Table
from mechid.ink.text_table import Column, Row

# A choice, not measured.
CLEAR = 3.0
"""Distance in standard errors from which the value of a record is named as different."""
# With two records, either could be the different one.
LEAST_TO_COMPARE = 3
"""Least number of records among which one can be named as different."""
CAMPAIGN_FILE, MECHANISM_FILE = "campaign.toml", "mechanism.toml"
NAME = Column("name", "name", words=True)
VALUE = (
    Column("value", "value"),
    Column("std error", "std_error", said="± σ"),
    Column("unit", "unit", words=True),
)


def missing_data(one: Missing) -> dict[str, Any]:
    """Return the data of an effect missing in the files, with formatted values."""
    rows = [_row(name, p) for name, p in one.parameters.items()]
    chi_square, share = f"{one.chi_square:.4g}", f"{100.0 * one.share:.3g}"
    file = MECHANISM_FILE if one.block else CAMPAIGN_FILE
    text = {"chi_square": chi_square, "share_percent": share, "apart": _most_apart(one), "file": file}
    text["where"] = _where(one, file)
    return {**one.to_dict(), "rows": rows, "text": text}


def _where(one: Missing, file: str) -> str:
    """Return the place of the text that declares an effect; text with only comments extends an existing table."""
    is_comment = all(line.startswith("#") for line in one.toml.splitlines())
    return f"in the table that {file} has already" if is_comment else f"at the end of {file}"


def _most_apart(one: Missing) -> str:
    """Name the record whose value differs most from the others, as the end of a sentence; empty if none does."""
    own = {n: (p.value, p.std_error) for n, p in one.parameters.items() if n.startswith("record.") and p.std_error}
    if len(own) < LEAST_TO_COMPARE:
        return ""
    # The median is not moved by the one value that differs.
    middle = median(value for value, _ in own.values())
    apart = {name: abs(value - middle) for name, (value, error) in own.items() if abs(value - middle) >= CLEAR * error}
    if not apart:
        return ""
    name = max(apart, key=lambda name: apart[name])
    value, error = with_sigma(*own[name])
    unit = "" if one.parameters[name].unit == "1" else f" {one.parameters[name].unit}"
    return f", most of all in {name.split('.')[1]}: {value} +- {error}{unit}"


def _row(name: str, p: EffectValue) -> dict[str, Any]:
    """Return the row of a parameter missing in mechanism and campaign, with its formatted value."""
    value, error = with_sigma(p.value, p.std_error)
    unit = "" if p.unit == "1" else p.unit
    own = {"name": name, "value": p.value, "std_error": p.std_error, "unit": p.unit}
    return {**own, "text": {"value": value, "std_error": error, "unit": unit}}


def own_table(rows: Sequence[Row]) -> Table:
    """Return the table of parameters missing in the files, with their values."""
    return Table((NAME, *VALUE), rows)
