"""Sections of a test report. Truth: a report written by hand."""

from dataclasses import replace

import pytest

from mechid.ink.document import BAD, Document, Section, Verdict, Words
from mechid.ink.in_markdown import document_markdown
from mechid.verification.declared import calibration_deviations, value_words
from mechid.verification.report import VerificationReport, Verified
from mechid.verification.sections import report_document

DIGEST = 8 * "0123abcd"
RUN = {
    "name": "run",
    "use": "run",
    "file": "run.csv",
    "sha256": DIGEST,
    "command": "full stepping",
    "started": "2026-04-02T10:00:00",
    "duration_s": 8.0,
    "sample_rate_hz": 2000.0,
}
RESULT = Document(
    title="A result", command="mechid emission", parts=(Verdict("1 failed", [("Why?", ["loud"])], BAD), Words("Lines."))
)
TEST = {
    "article": {"name": "SADM-200", "serial_number": "EM-3"},
    "test": {"reference": "TR-42", "set_up": "Clamped.", "conditions": "22 degrees."},
    "deviations": ["No run at 90 steps/s."],
    "instruments": [{"name": "9255C", "calibration_due": "2026-03-01"}, {"name": "DEWE", "calibrated": "2026-05-01"}],
    "bench": {"drive_axis": "z"},
    "files": {"cal.csv": 64 * "c"},
}
REPORT = VerificationReport(
    title="Test report",
    document=RESULT,
    verified=[Verified(requirement="Fx", method="test", value="0.2 N", limit="0.1 N", verdict="fail", evidence="run")],
    meaning="A fail is a fail.",
    test=TEST,
    noise=[Words("Quiet.")],
    runs=[RUN],
    deviations=["Fx: fail."],
    inputs={"campaign.toml": 64 * "e", "run.csv": DIGEST, "gone.csv": ""},
    versions={"mechid": "1.2", "python": "3.11"},
    files={"emission.json": 64 * "f"},
)


def headings(document):
    return [part.heading for part in document.parts if isinstance(part, Section)]


@pytest.fixture(scope="module")
def text():
    return document_markdown(report_document(REPORT))


def test_its_sections_are_those_of_a_test_report():
    assert headings(report_document(REPORT)) == [
        "Verification",
        "Test article",
        "Test set-up",
        "Instruments and calibration",
        "Noise",
        "Test conditions",
        "Records",
        "Results",
        "Deviations",
        "Software and files of the result",
    ]


def test_the_cover_has_article_reference_and_verdict(text):
    cover = text.split("\n## ")[0]
    for words in ("# Test report", "SADM-200, serial number EM-3", "**TR-42**", "2026-04-02", "mechid 1.2", "1 failed"):
        assert words in cover
    assert "Why?" not in cover


def test_the_verification_table_has_the_row(text):
    assert "| Fx | test | 0.2 N | 0.1 N |  | **fail** | run |" in text


def test_files_are_listed_once_with_whole_digests(text):
    rows = [line for line in text.splitlines() if DIGEST in line]
    assert rows == [f"| run.csv | record run | {DIGEST} |"]
    assert f"| campaign.toml | input | {64 * 'e'} |" in text
    assert f"| cal.csv | input | {64 * 'c'} |" in text
    assert f"| emission.json | result | {64 * 'f'} |" in text
    assert "gone.csv" not in text


def test_deviations_are_those_declared_and_those_found(text):
    declared, found = text.split("### Found by the evaluation")
    assert "- No run at 90 steps/s." in declared.split("### Declared")[1]
    found = found.split("\n## ")[0].strip().splitlines()
    assert found == [
        "- 9255C: its calibration was due on 2026-03-01, before the test of 2026-04-02.",
        "- DEWE: it was calibrated on 2026-05-01, after the test of 2026-04-02.",
        "- Fx: fail.",
    ]


def test_what_is_not_declared_is_said_and_nothing_made_up():
    text = document_markdown(report_document(replace(REPORT, test={}, runs=[], verified=[], deviations=[])))
    assert text.count("Not declared in campaign.toml.") == 4
    assert "No requirement was given; nothing is verified." in text
    assert "No deviation is declared in campaign.toml." in text
    assert "The evaluation found none." in text


def test_without_a_day_no_calibration_is_judged():
    assert list(calibration_deviations(TEST, "")) == []
    assert list(calibration_deviations(TEST, "2026-03-01")) == [
        "DEWE: it was calibrated on 2026-05-01, after the test of 2026-03-01."
    ]


def test_a_table_of_the_bench_is_said_in_words():
    assert value_words({"file": "c.csv", "on": True, "modes": [1, 2.5]}) == "file: c.csv; on: yes; modes: [1, 2.5]"
