"""Steps of the search for missing effects, with the model after each step."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from mechid.ink.digits import digits
from mechid.ink.table import Table
from mechid.ink.text_table import Column, OnPage, Row

AS_WRITTEN = "the mechanism as written"
COMPLETED_TITLE = "How the mechanism was completed"
COMPLETED = (
    "The records asked for the effects below, which were added to the mechanism file as mechanism_completed.toml; "
    "everything here is of that mechanism. The campaign's own mechanism file is as it was."
)
NOTHING_ADDED = "Completion was asked for, and nothing was added: the records ask for no effect of the library by name."
MEANING = (
    "Residual over noise is 1 where all is explained. The Bayesian criterion counts the misfit and each free "
    "parameter: the smaller, the better."
)
PATH_COLUMNS = (
    Column("step", "step"),
    Column("what", "what", words=True, on_page=OnPage(wide=True)),
    Column("residual / noise", "over_noise"),
    Column("free", "free"),
    Column("Bayesian criterion", "bic"),
)


def path_table(rows: Sequence[Row]) -> Table:
    """Return the table of steps of the search for missing effects."""
    return Table(PATH_COLUMNS, rows)


def path_rows(steps: Iterable[Mapping[str, Any]], first: Mapping[str, Any] | None = None) -> list[dict[str, Any]]:
    """Return a row for each step, numbered from 1.

    Parameters
    ----------
    steps : iterable of mapping
        Steps with the keys of `Step`; those from an estimate.json of an earlier version may lack some.
    first : mapping or None
        State before the first step, shown as row 0.
    """
    begin = [_row(0, AS_WRITTEN, first)] if first else []
    return [*begin, *(_row(number, _step_words(step), step) for number, step in enumerate(steps, 1))]


def completed_data(steps: Sequence[Mapping[str, Any]] | None) -> dict[str, Any] | None:
    """Return the report data of the steps that completed a mechanism; None if this was not requested."""
    if steps is None:
        return None
    return {"said": [COMPLETED, MEANING] if steps else [NOTHING_ADDED], "rows": path_rows(steps)}


def _step_words(step: Mapping[str, Any]) -> str:
    return f"{step['added']} added" if step.get("added") else f"{step.get('removed')} removed"


def _row(number: int, words: str, step: Mapping[str, Any]) -> dict[str, Any]:
    ratio, criterion, free = (step.get(key) for key in ("over_noise", "bic", "free"))
    return {
        "step": number,
        "what": words,
        "over_noise": ratio,
        "bic": criterion,
        "free": free,
        "text": {
            "step": str(number),
            "what": words,
            "over_noise": digits(ratio, 4),
            "bic": "-" if criterion is None else f"{criterion:.0f}",
            "free": "-" if free is None else str(free),
        },
    }
