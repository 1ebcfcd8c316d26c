"""Document of a comparison: preferred fit with reasons, and tables of scores, records and parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from mechid.comparisons.figures import (
    EVIDENCE_NAME,
    RECORDS_NAME,
    SPECTRA_NAME,
    comparison_figures,
    most_different_spectra,
)
from mechid.comparisons.numbers import FILE_NAME, comparison_numbers
from mechid.identification.result.estimate_file import json_text
from mechid.ink.document import IN_DOCUMENTS, Document, Lines, Picture, Rows, Section, Words
from mechid.ink.presenter import Presenter
from mechid.ink.table import Table
from mechid.ink.text_table import Column

HYPOTHESIS = Column("hypothesis", "name", words=True)
FITTED = (Column("free", "free"), Column("fitted", "counted"))
EFFECTIVE = (
    Column("AIC", "aic_effective"),
    Column("BIC", "bic_effective"),
    Column("AIC white", "aic"),
    Column("BIC white", "bic"),
)
SCORE_LAYOUTS = (
    ((HYPOTHESIS, *FITTED, *EFFECTIVE, Column("grade", "grade", words=True)),),
    ((HYPOTHESIS, *FITTED, *EFFECTIVE), (HYPOTHESIS, Column("grade", "grade", words=True))),
)
EVIDENCE = (
    "How much more than the best one each fit costs by the Bayesian criterion, which counts the misfit and each free "
    "number: by effective samples, and as if residuals were white. From 10 on it is very strong evidence."
)
SPECTRA = (
    "The RMS of each fit's residual by third octave, lines at orders of the step rate included, beside the record's "
    "noise: what a hypothesis lacks stands out where it moves the mechanism."
)
OF_RECORDS = "What each fit leaves of each record, as a share of what the first one leaves."


def comparison_document(data: Mapping[str, Any]) -> Document:
    """Make the document from the result of `comparison_numbers`."""
    names, preferred = data["hypotheses"], f" Preferred: {data['preferred']}." if data["preferred"] else ""
    wide, narrow = SCORE_LAYOUTS
    scores = Table(wide[0], data["scores"], narrower=(narrow,))
    return Document(
        title=f"{len(names)} fits of the same records",
        command="mechid compare",
        under=", ".join(names),
        tab=" and ".join(names),
        is_synthetic=bool(data["synthetic"]),
        parts=(
            Words(data["outcome"]["message"] + preferred, "strong"),
            Lines(data["grounds"], "because"),
            Lines(data["cautions"], "caution", "Cautions", "yellow"),
            Section(
                "Criteria above the least; by effective samples, and as if residuals were white",
                (Rows(scores), Words(EVIDENCE, where=IN_DOCUMENTS), Picture(EVIDENCE_NAME, "Evidence for each fit")),
                "criteria",
                "Criteria",
            ),
            Section(
                "Records; residual RMS in N m",
                (
                    Rows(_table(_record_layouts(names), data["records"])),
                    Words(OF_RECORDS, where=IN_DOCUMENTS),
                    Picture(RECORDS_NAME, "Residuals of each record by fit"),
                ),
                "records",
                "Records",
            ),
            _spectra(data),
            Section(
                f"Parameters; off: difference to {names[0]}, in sigmas",
                (Rows(_table(_parameter_layouts(names), data["parameters"])),),
                "parameters",
                "Parameters",
            ),
        ),
    )


def _spectra(data: Mapping[str, Any]) -> Section:
    every, drawn = data["spectra"]["records"], most_different_spectra(data)
    fewer = f" Drawn are the {len(drawn)} of {len(every)} records whose residuals differ most."
    words = Words(SPECTRA + (fewer if len(drawn) < len(every) else ""))
    parts = (words, Picture(SPECTRA_NAME, "Residual spectra of each record by fit")) if drawn else ()
    return Section("Residual spectra", parts, "spectra", "Spectra", where=IN_DOCUMENTS)


Layouts = tuple[tuple[tuple[Column, ...], ...], ...]


def _table(layouts: Layouts, rows: Sequence[Mapping[str, Any]]) -> Table:
    wide, *narrower = layouts
    return Table(wide[0], rows, group="", narrower=narrower)


def _record_layouts(names: Sequence[str]) -> Layouts:
    first = (Column("record", "name", words=True), Column("use", "use", words=True))
    size = (Column("samples", "samples"), Column("effective", "effective"))
    residuals = tuple(Column(name, f"residual_{i}") for i, name in enumerate(names))
    fits = tuple(Column(f"{name} fit %", f"fit_{i}") for i, name in enumerate(names))
    return ((first + size + residuals + fits,), (first + size, first[:1] + residuals, first[:1] + fits))


def _parameter_layouts(names: Sequence[str]) -> Layouts:
    first, unit = Column("parameter", "key", words=True), Column("unit", "unit", words=True)
    each = [
        (Column(name, f"value_{i}"), Column("+- sigma", f"sigma_{i}"), *([Column("off", f"off_{i}")] if i else []))
        for i, name in enumerate(names)
    ]
    return (((first, unit, *(c for columns in each for c in columns)),), tuple((first, *columns) for columns in each))


PRESENTER = Presenter(
    name="comparison",
    numbers=comparison_numbers,
    document=comparison_document,
    line=lambda found: f"{len(found.hypotheses)} fits, preferred: {found.preference.preferred or 'none'}",
    texts=lambda _found, data: {FILE_NAME: json_text(data)},
    figures=lambda _found, data: comparison_figures(data),
)
