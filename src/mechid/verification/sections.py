"""Test report as a document: cover, verification table, test, records with digests, results, deviations, software."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from mechid.ink.data import Data
from mechid.ink.digits import plain
from mechid.ink.document import Document, Facts, Lines, Part, Rows, Section, Verdict, Words
from mechid.ink.table import Table
from mechid.ink.text_table import Column
from mechid.verification.declared import (
    LABELS,
    article_parts,
    calibration_deviations,
    condition_parts,
    instrument_parts,
    set_up_parts,
)
from mechid.verification.report import VerificationReport, Verified

VERIFICATION = (
    Column("requirement", "requirement", words=True),
    Column("method", "method", words=True),
    Column("value", "value", words=True),
    Column("limit", "limit", words=True),
    Column("margin", "margin", words=True),
    Column("verdict", "verdict", words=True, strong=True),
    Column("evidence", "evidence", words=True),
)
RUNS = (
    Column("record", "name", words=True),
    Column("use", "use", words=True),
    Column("command", "command", words=True),
    Column("started", "started", words=True),
    Column("lasts, s", "duration"),
    Column("sample rate, Hz", "rate"),
)
FILES = (Column("file", "file", words=True), Column("of", "of", words=True), Column("SHA-256", "sha256", words=True))
NO_REQUIREMENT = "No requirement was given; nothing is verified."
NOTHING_DECLARED = "No deviation is declared in campaign.toml."
NOTHING_FOUND = "The evaluation found none."
DIGESTS = "Digests of the files as they were read. A file with another digest is not the one that was evaluated."
ISO_DAY = len("2026-03-31")


def report_document(report: VerificationReport) -> Document:
    """Return the document of a test report."""
    test, document = report.test, report.document
    return replace(
        document,
        title=report.title,
        under=_article_words(test),
        parts=(
            *_cover(report),
            Section("Verification", list(_verification(report))),
            Section("Test article", list(article_parts(test))),
            Section("Test set-up", [*set_up_parts(test), *report.set_up]),
            Section("Instruments and calibration", [*instrument_parts(test), *report.instruments]),
            Section("Noise", report.noise),
            Section("Test conditions", [*condition_parts(test), *report.conditions]),
            Section("Records", list(_records(report))),
            Section("Results", document.parts),
            Section("Deviations", list(_deviations(report))),
            Section("Software and files of the result", list(_software(report))),
        ),
    )


def _article_words(test: Mapping[str, Data]) -> str:
    article = test.get("article") or {}
    number = f", serial number {article['serial_number']}" if article.get("serial_number") else ""
    return f"{article['name']}{number}" if article.get("name") else ""


def _cover(report: VerificationReport) -> Iterator[Part]:
    test = report.test.get("test") or {}
    facts = [(LABELS[key], value) for key, value in test.items() if key in LABELS]
    facts += [("records taken", _span(report.runs))] if _days(report.runs) else []
    facts += [("evaluated with", ", ".join(f"{name} {number}" for name, number in _first(report.versions)))]
    yield Facts(facts)
    # The first page has the verdict alone; its reasons stand with the results.
    headlines = [part for part in report.document.parts if isinstance(part, Verdict)]
    yield from (Verdict(part.headline, tone=part.tone) for part in headlines[:1])


def _first(versions: Mapping[str, str]) -> list[tuple[str, str]]:
    return [(name, number) for name, number in versions.items() if name == "mechid"]


def _days(runs: Sequence[Data]) -> list[str]:
    """Return the days on which records were started, in order."""
    return sorted({str(run["started"])[:ISO_DAY] for run in runs if run.get("started")})


def _span(runs: Sequence[Data]) -> str:
    days = _days(runs)
    return days[0] if days[0] == days[-1] else f"{days[0]} to {days[-1]}"


def _verification(report: VerificationReport) -> Iterator[Part]:
    if not report.verified:
        yield Words(NO_REQUIREMENT)
        return
    yield Rows(verification_table(report.verified), "Verification")
    yield Words(report.meaning, "soft")


def verification_table(verified: Sequence[Verified]) -> Table:
    """Return the table of requirements with their verdicts and evidence."""
    return Table(VERIFICATION, [vars(one) for one in verified])


def _records(report: VerificationReport) -> Iterator[Part]:
    rows = [
        {
            **run,
            "started": run.get("started") or "",
            "command": run.get("command") or "",
            "duration": plain(run["duration_s"], 5) if run.get("duration_s") else "",
            "rate": plain(run["sample_rate_hz"], 7) if run.get("sample_rate_hz") else "",
        }
        for run in report.runs
    ]
    yield Rows(Table(RUNS, rows), "Records")
    # A recording of many stretches is one file.
    files = dict.fromkeys((run["file"], run["name"], run["sha256"]) for run in report.runs if run.get("file"))
    listed = [{"file": file, "of": f"record {name}", "sha256": digest} for file, name, digest in files if digest]
    own = {file for file, _, _ in files}
    named = report.test.get("files") or {}
    others = {**{name: digest for name, digest in report.inputs.items() if name not in own}, **named}
    listed += [{"file": name, "of": "input", "sha256": digest} for name, digest in others.items() if digest]
    yield Words(DIGESTS)
    yield Rows(Table(FILES, listed), "Files that were read")


def _deviations(report: VerificationReport) -> Iterator[Part]:
    declared = report.test.get("deviations") or []
    yield Section("Declared", [Lines(declared) if declared else Words(NOTHING_DECLARED)])
    days = _days(report.runs)
    day = str((report.test.get("test") or {}).get("date", "")) or (days[-1] if days else "")
    found = [*calibration_deviations(report.test, day), *report.deviations]
    yield Section("Found by the evaluation", [Lines(found) if found else Words(NOTHING_FOUND)])


def _software(report: VerificationReport) -> Iterator[Part]:
    yield Facts([(name, number) for name, number in report.versions.items()])
    rows = [{"file": name, "of": "result", "sha256": digest} for name, digest in report.files.items()]
    yield Rows(Table(FILES, rows), "Files of the result beside this one")
