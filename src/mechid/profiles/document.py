"""Document of profiles: intervals by standard error and by likelihood, and likelihood curves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.ink.document import IN_DOCUMENTS, Document, Lines, Picture, Rows, Section, Words
from mechid.ink.presenter import Presenter
from mechid.ink.table import Table
from mechid.ink.text_table import Column
from mechid.profiles.figures import figure_name, profile_figures
from mechid.profiles.numbers import profile_numbers, profile_texts

NAME = (Column("parameter", "name", words=True), Column("estimate", "estimate"), Column("unit", "unit", words=True))
LIMITS = (
    Column("local from", "local_low"),
    Column("to", "local_high"),
    Column("profile from", "low"),
    Column("to", "high"),
    Column("for colour from", "coloured_low"),
    Column("to", "coloured_high"),
)
INTERVALS = "95 % intervals: by the standard error, and by profile likelihood"
CURVE = (
    "How the cost rises, in the noise's variances, where the parameter is held and all others are fitted again: points "
    "and line. Dashed, the parabola of the standard error. Dotted, the rise at which the 95 % interval ends, and its "
    "ends. Where curve and parabola part, the interval is not that of the standard error."
)


def profile_document(data: Mapping[str, Any]) -> Document:
    """Make the document from the result of `profile_numbers`."""
    rows = [{"name": name, **one} for name, one in data["profiles"].items()]
    table = Table((*NAME, *LIMITS), rows, narrower=((NAME, (NAME[0], *LIMITS)),))
    curves = [
        Section(name, (Picture(figure_name(name), f"Rise of the cost over {name}"),), name, name)
        for name in data["profiles"]
    ]
    return Document(
        title="Profiles of the likelihood",
        command="mechid profile",
        tab=", ".join(data["profiles"]),
        is_synthetic=bool(data["synthetic"]),
        parts=(
            Section(INTERVALS, (Rows(table),), "intervals", "Intervals"),
            Lines(data["warnings"], "warning", "Warnings", "yellow"),
            Section("The curves", (Words(CURVE), *curves), "curves", where=IN_DOCUMENTS),
        ),
    )


PRESENTER = Presenter(
    name="profile",
    numbers=lambda found: profile_numbers(found.profiles, synthetic=found.synthetic, fit_digest=found.fit_digest),
    document=profile_document,
    line=", ".join,
    texts=lambda _found, data: profile_texts(data),
    figures=lambda _found, data: profile_figures(data),
)
