"""Use of a record in a word and in a sentence, also of one that the fit left out against its file."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from mechid.analysis.hypothesis import LEFT_OUT
from mechid.ink.data import Data


def use_word(use: str, *, left_out: bool) -> str:
    """Return the use of a record as shown in tables.

    Examples
    --------
    >>> use_word("validate", left_out=False), use_word("validate", left_out=True)
    ('validate', 'left out')
    """
    return LEFT_OUT if left_out else use


def with_left_out(rows: Sequence[dict[str, Any]], names: Collection[str]) -> list[dict[str, Any]]:
    """Add to each row whether the fit left its record out."""
    return [{**row, "left_out": row["name"] in names} for row in rows]


def with_use(rows: Sequence[dict[str, Any]], names: Collection[str]) -> list[dict[str, Any]]:
    """Add to each row whether its record was left out, and the text of its use."""
    return [
        {**row, "text": {**row["text"], "use": use_word(row["use"], left_out=row["left_out"])}}
        for row in with_left_out(rows, names)
    ]


def held_out(rows: Sequence[Data]) -> list[Data]:
    """Return the rows of records that the campaign file holds out of the fit."""
    return [row for row in rows if row["use"] == "validate" and not row["left_out"]]


def left_out(rows: Sequence[Data]) -> list[Data]:
    """Return the rows of records that the fit left out although the campaign file declares them for estimation."""
    return [row for row in rows if row["left_out"]]


def left_out_words(name: str, fit_percent: str) -> str:
    """Return a sentence on a record that was left out."""
    return (
        f"Record {name} was left out of the fit, although the campaign file gives it to estimate from: it contradicts "
        f"the other records, as the warnings say. Their model predicts it with a fit of {fit_percent} %."
    )
