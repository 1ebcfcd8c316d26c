"""Test report of a budget: verification table, and the test that the fit in flight rests on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mechid.budgets.texts import requirement_text
from mechid.identification.result.estimate_file import DIGEST
from mechid.ink.data import Data
from mechid.ink.digits import digits
from mechid.ink.document import Document, Facts, Part, Rows, Words
from mechid.ink.table import Table
from mechid.ink.text_table import Column
from mechid.verification.report import VerificationReport, Verified, evidence_words
from mechid.verification.sections import report_document

TITLE = "Verification report of the microvibration budget {}"
ANALYSIS = "analysis"
MEANING = (
    "Analysis: prediction with the mechanism that was identified from the records of its test. Value: level at the "
    "requirement's confidence, at the worst rate. Margin: lower 95 % limit of the remaining share of the limit; above "
    "0 the requirement is met. Not sure: the level is below its limit, its upper 95 % limit is not."
)
NOISE = (
    Column("record", "name", words=True),
    Column("noise, RMS", "noise"),
    Column("level rests on", "basis", words=True),
)
RESTS = "The budget is an analysis; it rests on the test of the mechanism that is described here."
NO_NOISE = "The fit holds no records, so that nothing is known of their noise."


def budget_report(data: Mapping[str, Any], document: Document, files: Mapping[str, str]) -> Document:
    """Return the report.

    Parameters
    ----------
    data : mapping
        As `budget_numbers` makes it.
    document : Document
        Of the budget.
    files : mapping of str to str
        SHA-256 of the files of the result, by name.
    """
    fit, provenance = data["fit"], data["provenance"]
    return report_document(
        VerificationReport(
            title=TITLE.format(data["file"]),
            document=document,
            verified=[
                *(_verification_row(data, one) for one in data["requirements"]),
                *(_exported_row(data, one) for one in data["emission_requirements"]),
            ],
            meaning=MEANING,
            test=fit["test"],
            set_up=[Words(RESTS)],
            noise=list(_noise(fit["records"])),
            conditions=[Facts(list(_flight(data)))],
            runs=fit["records"],
            deviations=list(_deviations(data)),
            inputs={**provenance["inputs_sha256"], **fit["inputs_sha256"]},
            versions=provenance["versions"],
            files=files,
        )
    )


def _verification_row(data: Data, one: Data) -> Verified:
    text, decided = requirement_text(one), one["decided"]
    at = f" at {text['rate']} steps/s" if decided["at_rate"] is not None else ""
    sigma = f" ± {text['sigma']}" if text["sigma"] else ""
    return Verified(
        requirement=f"{one['requirement']}, {one['mode']} ({text['index']}, {one['axis']}, {text['statistics']})",
        method=ANALYSIS,
        value=f"{text['level']}{sigma} rad{at}, {text['coupling']}",
        limit=f"{text['limit']} rad",
        margin=f"{text['deciding']} %",
        verdict=text["met"],
        evidence=evidence_words("fitted mechanism", str(data["provenance"]["fit"][DIGEST] or "")),
    )


def _exported_row(data: Data, one: Data) -> Verified:
    """Return the row of a requirement on the torque at the interface."""
    text, unit = one["text"], str(one["unit"]).replace("*", " ")
    where = f" at {text['frequency']} Hz, {text['rate']} steps/s, {text['mode']}" if one["worst"] else ""
    return Verified(
        requirement=f"{one['name']} ({one['direction']}, {one['kind'].replace('_', ' ')})",
        method=ANALYSIS,
        value=f"{text['value']} {unit}{where}" if one["worst"] else "none",
        limit=f"{text['limit']} {unit}" if one["worst"] else "",
        margin=f"{text['margin']} dB" if text["margin"] else "",
        verdict=text["verdict"],
        evidence=evidence_words("fitted mechanism", str(data["provenance"]["fit"][DIGEST] or "")),
    )


def _noise(records: list[Data]) -> Iterator[Part]:
    rows = [
        {"name": one["name"], "noise": digits(one["noise_sigma"], 3), "basis": one["noise_rests_on"]}
        for one in records
        if one["noise_sigma"] is not None
    ]
    caption = "Noise of the records, in the unit of the leading channel"
    yield Rows(Table(NOISE, rows), caption) if rows else Words(NO_NOISE)


def _flight(data: Data) -> Iterator[tuple[str, str]]:
    """Yield what the budget analyses: structure, lines of sight, modes of operation."""
    yield "structure", data["structure"]
    yield "lines of sight", ", ".join(data["line_of_sight"])
    yield "modes of operation", ", ".join(mode["name"] for mode in data["modes"])
    yield "grade of the fit", data["fit"]["grade"]


def _deviations(data: Data) -> Iterator[str]:
    for one in data["requirements"]:
        if not one["decided"]["met"]:
            yield f"{one['requirement']}, {one['mode']}: {requirement_text(one)['met']}."
    for one in data["emission_requirements"]:
        if one["verdict"] != "pass":
            yield f"{one['name']}: {one['text']['verdict']}."
    yield from data["notes"]
    yield from data["warnings"]
