"""`mechid report`; truth: the files that identify left, and what it says of those that are not there."""

import hashlib
import json
import shutil
from dataclasses import replace
from types import SimpleNamespace

import pytest

import word_files
from mechid.campaign import load_campaign
from mechid.identification import run as identification
from mechid.identification.identify import identify
from mechid.identification.result.grade import FitOutcome, Grade

NAMES = ["report.html", "report.json", "report.md"]


@pytest.fixture(scope="module")
def fitted():
    return {}


@pytest.fixture
def result(fitted, run, staged, tmp_path, tmp_path_factory):
    """Return a campaign's folder and a copy of its result folder; identified once."""
    if not fitted:
        kept = tmp_path_factory.mktemp("kept")
        shutil.copytree(staged, kept / "campaign")
        identified = run("identify", kept / "campaign", "--out", kept / "out", "--workers", 1, "--docx")
        assert identified.exit_code == 0, identified.stderr
        fitted.update(kept=kept)
    out = shutil.copytree(fitted["kept"] / "out", tmp_path / "out")
    return SimpleNamespace(out=out, campaign=fitted["kept"] / "campaign")


def test_it_makes_the_report_of_identify_again(run, result):
    before = {name: (result.out / name).read_text() for name in NAMES}
    figures = sorted(path.name for path in (result.out / "figures").iterdir())
    for name in NAMES[::2]:
        (result.out / name).unlink()
    shutil.rmtree(result.out / "figures")
    docx = (result.out / "report.docx").read_bytes()
    made = run("report", result.out, "--docx")
    assert made.exit_code == 0, made.stderr
    assert [
        f"written: {result.out / name}" for name in [*NAMES, "report.docx", "figures", "residual.json"]
    ] == made.stdout.splitlines()
    assert sorted(path.name for path in (result.out / "figures").iterdir()) == figures
    assert json.loads((result.out / "report.json").read_text()) == json.loads(before["report.json"])
    assert (result.out / "report.md").read_text() == before["report.md"]
    assert (result.out / "report.docx").read_bytes() == docx


def test_the_word_document_has_the_figures_and_the_digests_of_the_files_beside_it(result):
    """Truth: the files."""
    file = word_files.opened(result.out / "report.docx")
    left = {row[0]: row[2] for row in word_files.table_under(file, "Files of the result beside this one")[1:]}
    assert set(left) == {"estimate.json", "mechanism.toml", "report.json"}
    for name, digest in left.items():
        assert hashlib.sha256((result.out / name).read_bytes()).hexdigest() == digest
    captions = [text for text in word_files.captions(file) if text.startswith("Figure")]
    assert len(captions) == len(file.inline_shapes) >= 3


def test_without_a_journal_the_campaign_has_to_be_named(refused, run, result):
    (result.out / "journal.jsonl").unlink()
    assert "give it as --campaign" in refused(3, "report", result.out)
    assert run("report", result.out, "--campaign", result.campaign).exit_code == 0


def test_a_campaign_that_was_moved_away_is_told(refused, result):
    journal = result.out / "journal.jsonl"
    journal.write_text(journal.read_text().replace(str(result.campaign), "/nowhere"))
    assert "does not exist; give it as --campaign" in refused(3, "report", result.out)


def test_another_campaign_is_refused(refused, result, bench):
    assert "is not the file that was identified" in refused(3, "report", result.out, "--campaign", bench)


def test_an_empty_folder_is_refused(refused, tmp_path):
    assert "no such file" in refused(3, "report", tmp_path)


def test_a_report_that_fails_leaves_the_estimate(run, staged, tmp_path, monkeypatch):
    """Truth: the rule that the estimate is on disk before the report is begun."""

    def fail(*_, **__):
        raise RuntimeError("no font")

    monkeypatch.setattr("mechid.reports.files.write_report", fail)
    result = run("identify", staged, "--out", tmp_path / "out", "--workers", 1)
    assert result.exit_code == 0
    assert "no report was made (RuntimeError: no font)" in result.stderr
    assert f'"mechid report {tmp_path / "out"}" tries again' in result.stderr
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "estimate.json",
        "journal.jsonl",
        "mechanism.toml",
        "report.json",
        "residual.json",
    ]


def test_a_failed_fit_has_a_report_too(run, staged, tmp_path, monkeypatch):
    """Values from which no simulation comes to its end: every prediction is NaN."""
    fit = identify(load_campaign(staged), workers=1)
    wild = fit.mechanism.with_values({"gear.stiffness": float("nan")})
    failed = replace(fit, mechanism=wild, outcome=FitOutcome.FAILED, grade=Grade.FAILED)
    monkeypatch.setattr(identification, "search", lambda *_, **__: failed)
    result = run("identify", staged, "--out", tmp_path / "out")
    assert result.exit_code == 5
    assert "no report was made" not in result.stderr
    summary = json.loads((tmp_path / "out" / "report.json").read_text())["summary"]
    assert (summary["grade"], summary["tone"]) == ("failed", "bad")
