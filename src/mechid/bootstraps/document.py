"""Document of a bootstrap: scatter of the estimates and their standard errors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.bootstraps.figures import PAIRS_NAME, SCATTER_NAME, bootstrap_figures, closest_pairs
from mechid.bootstraps.numbers import bootstrap_numbers, bootstrap_texts
from mechid.ink.document import IN_DOCUMENTS, Document, Lines, Picture, Rows, Section, Words
from mechid.ink.presenter import Presenter
from mechid.ink.table import Table
from mechid.ink.text_table import Column

NAME = (Column("parameter", "name", words=True), Column("estimate", "estimate"), Column("unit", "unit", words=True))
SCATTER = (
    Column("+- sigma", "std_error", said="± σ"),
    Column("scatter", "deviation"),
    Column("shift", "mean_shift"),
    Column("95 % from", "low"),
    Column("to", "high"),
)
DRAWS = (
    "Each parameter over the draws, less the estimate, in standard errors: the bar holds 95 % of the refits, the point "
    "is their mean. Shaded, what the standard error says."
)
PAIRS = (
    "The pairs of parameters whose refits go together most: a point for each draw, in standard errors from the "
    "estimate."
)


def bootstrap_document(data: Mapping[str, Any]) -> Document:
    """Make the document from the result of `bootstrap_numbers`."""
    rows = [{"name": name, **one} for name, one in data["parameters"].items()]
    table = Table((*NAME, *SCATTER), rows, narrower=((NAME, (NAME[0], *SCATTER)),))
    heading = f"{data['draws']} refits; scatter: their standard deviation, shift: their mean less the estimate"
    pairs = (Words(PAIRS), Picture(PAIRS_NAME, "Refits of pairs of parameters")) if closest_pairs(data) else ()
    return Document(
        title="A bootstrap",
        command="mechid bootstrap",
        under=f"{data['draws']} draws, seed {data['seed']}",
        is_synthetic=bool(data["synthetic"]),
        parts=(
            Section(heading, (Rows(table),), "scatter", "Scatter"),
            Lines(data["warnings"], "warning", "Warnings", "yellow"),
            Section(
                "Scatter beside the standard errors",
                (Words(DRAWS), Picture(SCATTER_NAME, "Refits of each parameter in standard errors")),
                "drawn",
                "Drawn",
                where=IN_DOCUMENTS,
            ),
            Section("Parameters that go together", pairs, "pairs", "Pairs", where=IN_DOCUMENTS),
        ),
    )


PRESENTER = Presenter(
    name="bootstrap",
    numbers=lambda found: bootstrap_numbers(found, found.seed),
    document=bootstrap_document,
    line=lambda found: f"{len(found.draws)} draws of {len(found.spreads)} parameters",
    texts=lambda _found, data: bootstrap_texts(data),
    figures=lambda _found, data: bootstrap_figures(data),
)
