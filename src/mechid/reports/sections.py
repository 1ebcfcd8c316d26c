"""Report of a fit as a document: verdict, parameters, records, information, stages, model, provenance."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from mechid.diagnoses.effect_rows import own_table
from mechid.diagnoses.path import COMPLETED_TITLE, path_table
from mechid.identification.result.grade import MECHANISM_FILE_CAUSES
from mechid.ink.document import (
    IN_DOCUMENTS,
    ON_TERMINAL,
    Code,
    Document,
    Html,
    Lines,
    Part,
    Rows,
    Section,
    Verdict,
    Words,
)
from mechid.ink.table import Table
from mechid.ink.text_table import EVERYWHERE, MARKDOWN, PAGE, Column, OnPage
from mechid.reports.added_effects import LACKING
from mechid.reports.dependence import dependence_section
from mechid.reports.record_sections import record_parts
from mechid.reports.side import SIDE_SAID, SIDE_TITLE
from mechid.reports.tables import known_table, parameter_table, prior_table, side_table, stage_table
from mechid.reports.verdict import verdict

if TYPE_CHECKING:
    from mechid.kernel.equation_text import Section as Equations
    from mechid.reports.curves import Curves

ABOUT_ALL = "all records"
ABOUT_RECORDS = ("record ", "records ")
"""Prefixes of warnings that concern single records."""
PARAMETERS = (
    "Catalogue values and estimates with one standard error, which counts noise of any colour and what the model "
    "lacks; the last digits of an estimate are those of its error."
)
TRUTH = "Off: estimate less truth, in standard errors."
PRIORS = "Records alone: the standard error without any prior, empty where the last fit left them out."
RESONANCES = "Resonances of the estimate, undamped: {}."
NOTES = "What records of this kind cannot tell"
ORIGIN = (Column("", "label", words=True), Column("", "value", words=True))
INPUTS = (
    Column("input", "file", words=True),
    Column("SHA-256", "digest", words=True, on_page=OnPage(style="word digest")),
)


def report_document(
    data: Mapping[str, Any], curves: Sequence[Curves] = (), equations: Sequence[Equations] = ()
) -> Document:
    """Return the document of a fit.

    Parameters
    ----------
    data : mapping
        As `report_data` makes it, for a terminal; for Markdown and a page as `report_contents` does.
    curves : sequence of Curves
        Of the records, in their order, each with figures of its own.
    equations : sequence of Section
        Of the mechanism, in MathML.
    """
    version = data["provenance"].get("versions", {}).get("mechid", "")
    return Document(
        title=data.get("title", "Identification"),
        command="mechid report",
        under=f"Identification report, mechid {version}",
        is_synthetic=bool(data["synthetic"]),
        parts=(
            *_verdict(data),
            *_completion(data["completed"]),
            *map(_undeclared_effect, data["missing"]),
            _parameters(data),
            *record_parts(data, curves),
            *_side(data["side"]),
            *_conclusions(data),
            _stages(data),
            Section("Model", [_equations(one) for one in equations], "model", "Model", where=(PAGE,)),
            _provenance(data),
        ),
    )


def _verdict(data: Mapping[str, Any]) -> Iterator[Part]:
    """Yield the verdict; a terminal adds warnings and next steps, beginning with errors in the files."""
    tone, headline = verdict(data)
    questions = [(q["question"], q["answers"]) for q in data["summary"]["questions"]] if "summary" in data else []
    yield Verdict(headline, questions, tone, Lines(data["warnings"], heading="Warnings", where=IN_DOCUMENTS))
    about_all = [line for line in data["warnings"] if line.startswith(ABOUT_ALL)]
    about_records = [line for line in data["warnings"] if line.startswith(ABOUT_RECORDS)]
    others = [line for line in data["warnings"] if not line.startswith((ABOUT_ALL, *ABOUT_RECORDS))]
    of_file = [reason for reason in data["reasons"] if reason["cause"] in MECHANISM_FILE_CAUSES]
    reasons = [reason for reason in data["reasons"] if reason not in of_file]
    found = [f"{one['name']}: {one['words']}{one['text']['apart']} (below)" for one in data["missing"]]
    outcome = data["outcome"]["message"]
    # A reason may begin with the sentence of the outcome, which would then appear twice.
    is_said = any(reason["text"].startswith(outcome) for reason in data["reasons"])
    parts: tuple[Part, ...] = (
        Lines(found, "found, not declared", style="yellow"),
        Lines(about_all, "warning", style="yellow"),
        *_reasons(of_file),
        Lines(about_records, "warning", style="yellow"),
        *_reasons(reasons),
        Words("" if is_said else outcome),
        Lines(others, "warning", style="yellow"),
        Section(LACKING, (Lines(data["lacking"]),)),
    )
    yield Section("", parts, where=ON_TERMINAL)


def _reasons(reasons: Sequence[Mapping[str, Any]]) -> Iterator[Lines]:
    """Yield the reasons for the grade of a fit, each with its next step."""
    for reason in reasons:
        yield Lines([reason["text"]], reason["words"])
        yield Lines([reason["next_command"]], "next")


def _completion(completed: Mapping[str, Any] | None) -> Iterator[Section]:
    """Yield the steps that completed the mechanism, if completion was requested."""
    if completed is not None:
        parts: tuple[Part, ...] = (*map(Words, completed["said"]), Rows(path_table(completed["rows"])))
        yield Section(COMPLETED_TITLE, parts, "completed", "Completed")


def _undeclared_effect(one: Mapping[str, Any]) -> Section:
    """Return the section of an effect that the fit added, with the text that declares it."""
    text = one["text"]
    file, added = ("mechanism", "; it was added") if one["block"] else ("campaign", "")
    said = (
        f"The {file} file does not say it, and the records ask for it{added}: chi-square {text['chi_square']} for "
        f"{one['dof']}, {text['share_percent']} % of what they hold beyond noise{text['apart']}."
    )
    declared = Section(
        f"To declare it, {text['where']}", (Code(one["toml"].strip(), where=EVERYWHERE),), is_folded=True
    )
    return Section(
        f"Not declared: {one['words']} ({one['name']})", (Words(said), Rows(own_table(one["rows"])), declared)
    )


def _parameters(data: Mapping[str, Any]) -> Section:
    held = [row for row in data["parameters"] if row["reason"] and row["estimated"]]
    lines = [f"**{row['name']}**: {row['text']['status']}; {row['reason']}" for row in held]
    parts: list[Part] = [
        Words(PARAMETERS, where=IN_DOCUMENTS),
        Words(TRUTH if data["has_truth"] else ""),
        Rows(parameter_table(data)),
        Lines(lines, where=IN_DOCUMENTS),
    ]
    if prior_table(data).rows:
        parts.append(Section("Priors", (Words(PRIORS), Rows(prior_table(data)))))
    if "meanings" in data:
        known = (Rows(known_table(data)),)
        parts.append(Section("Known values, not estimated", known, is_folded=True, where=IN_DOCUMENTS))
    return Section("Parameters", parts, "parameters", "Parameters")


def _side(rows: Sequence[Mapping[str, Any]]) -> Iterator[Section]:
    if rows:
        parts = (Words(SIDE_SAID, where=IN_DOCUMENTS), Rows(side_table(rows)))
        yield Section(SIDE_TITLE, parts, "side", "Beside the torque")


def _conclusions(data: Mapping[str, Any]) -> Iterator[Part]:
    """Yield resonances, dependence and information of the estimate, in documents only."""
    if "summary" in data:
        found = "; ".join(f"{one['name']} {one['text']['frequency_hz']} Hz" for one in data["resonances"])
        yield Words(RESONANCES.format(found) if found else "", where=IN_DOCUMENTS)
        yield dependence_section(data)


def _stages(data: Mapping[str, Any]) -> Section:
    notes = Section(NOTES, (Lines(data["notes"], "note", style="dim"),))
    return Section(
        "Stages of the search", (Rows(stage_table(data["stages"])), Words(data["arrived"]), notes), "stages", "Stages"
    )


def _equations(one: Equations) -> Section:
    rows = "".join(
        f'<tr><td><math displaystyle="true">{left}</math></td><td>{one.sign}</td>'
        f'<td><math displaystyle="true">{right}</math></td></tr>'
        for left, right in one.lines
    )
    return Section(one.title, (Html(f'<div class="equations"><table>{rows}</table></div>'),))


def _provenance(data: Mapping[str, Any]) -> Section:
    digests = data["provenance"].get("inputs_sha256", {}).items()
    origin = Table(ORIGIN, [{"label": label, "value": value} for label, value in data.get("origin", ())], style="plain")
    inputs = Table(INPUTS, [{"file": file, "digest": digest} for file, digest in digests], style="plain")
    parts = (Rows(origin), Rows(inputs))
    return Section("Provenance", parts, "provenance", "Provenance", where=(MARKDOWN, PAGE))
