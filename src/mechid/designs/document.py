"""Design document: gain, alternative effects, errors before and after, records to drive, step loss."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mechid.designs.alternative_tables import pair_table, rival_lines
from mechid.designs.design import Design
from mechid.designs.figures import ERRORS, ERRORS_BY_RECORD, LOSS, RATES, TORQUE, design_figures
from mechid.designs.numbers import design_numbers, rate_rows
from mechid.designs.proposal import write_proposal
from mechid.designs.sentences import JSON_NAME, headline, hole_lines, left_out_lines, loss_words, peak_lines
from mechid.designs.tables import loss_table, parameter_table, record_table
from mechid.identification.result.estimate_file import json_text
from mechid.ink.data import Data
from mechid.ink.document import IN_DOCUMENTS, Document, Lines, Part, Picture, Rows, Section, Words
from mechid.ink.page_rules import COMPACT, ONE_COLUMN
from mechid.ink.presenter import Presenter

RATES_NAME = "torque_over_rate.csv"
AT = "At the values believed, and the median over the mechanisms that may be true."
BY_RECORD = (
    "The standard error of each parameter over its value (of a phase, in rad), before the first record and after each "
    "one: the median over the mechanisms that may be true. A dot, or no colour: more than the value "
    "itself."
)
RATES_WORDS = "The rates of the records, one after the other in this order, with the time between them."
STYLE = """
@media (min-width: 641px) { .scroll td.word { white-space: nowrap; } .scroll thead th { white-space: normal; } }
"""
"""Units and names stay on one line where there is room; headers may wrap."""
BAND = "The line is at the values believed; the band holds all mechanisms that may be true."


def design_document(data: Data) -> Document:
    """Return the document of the data of `design_numbers`."""
    return Document(
        title="Design of the next test",
        command="mechid design",
        under=f"Campaign {data['campaign']}",
        is_synthetic=bool(data["synthetic"]),
        parts=(
            Words(headline(data), "strong"),
            Lines(data["warnings"], "warning", "Warnings", "yellow"),
            *_rivals(data),
            Section("Standard errors", _errors(data), "errors", "Standard errors"),
            Section("Records, the most informative first", _records(data), "records", "Records"),
            Section("Step loss", _step_loss(data), "step-loss", "Step loss"),
            Section("Torque over the step rate", _torque(data), "torque", "Torque"),
            Section("Candidates left out", (Lines(left_out_lines(data), "left out"),), "left-out", "Left out"),
        ),
    )


def _rivals(data: Data) -> Iterator[Section]:
    if data["rivals"]:
        parts = (Lines(rival_lines(data)), Rows(pair_table(data)))
        yield Section("Effects that the records so far cannot tell apart", parts, "rivals", "Rival effects")


def _errors(data: Data) -> tuple[Part, ...]:
    return (
        Words(AT),
        Rows(parameter_table(data)),
        Picture(ERRORS, "Standard errors of the parameters before and after"),
        Words(BY_RECORD, where=IN_DOCUMENTS),
        Picture(ERRORS_BY_RECORD, "Standard error of each parameter before the first record and after each one"),
    )


def _records(data: Data) -> tuple[Part, ...]:
    return (
        Rows(record_table(data)),
        Words(RATES_WORDS, where=IN_DOCUMENTS),
        Picture(RATES, "Step rate of the chosen records over the test time"),
    )


def _step_loss(data: Data) -> tuple[Part, ...]:
    holes = Lines(hole_lines(data), "holes", "Rates at which steps are lost though higher ones hold")
    picture = Picture(LOSS, "Rates beyond which steps are lost over inertia, supply and friction")
    return (Words(loss_words(data)), Rows(loss_table(data)), holes, picture)


def _torque(data: Data) -> tuple[Part, ...]:
    picture = Picture(TORQUE, "Torque amplitude over the step rate of each stepping")
    return (Lines(peak_lines(data), "amplitude"), Words(BAND, where=IN_DOCUMENTS), picture)


def _texts(_design: Design, data: Mapping[str, Any]) -> dict[str, Any]:
    return {JSON_NAME: json_text(data), RATES_NAME: rate_rows(data)}


PRESENTER = Presenter(
    name="design",
    numbers=design_numbers,
    document=design_document,
    line=lambda found: ", ".join(record.name for record in found.chosen.records) or "no record",
    texts=_texts,
    files=write_proposal,
    figures=lambda _found, data: design_figures(data),
    style=COMPACT + ONE_COLUMN + STYLE,
)
