"""`mechid identify`: files, exit codes, progress. Truth: the bench's own values, and the contract."""

import hashlib
import json
from types import SimpleNamespace

import pytest

from mechid.campaign import load_mechanism
from mechid.campaign.bench import TRUTH
from mechid.identification import run as identification
from mechid.identification.identify import identify
from mechid.identification.result.grade import GRADE_WORDS, Cause, FitOutcome, Grade, Reason

FILES = [
    "estimate.json",
    "figures",
    "journal.jsonl",
    "mechanism.toml",
    "report.html",
    "report.json",
    "report.md",
    "residual.json",
]
WITHOUT_REPORT = ["estimate.json", "journal.jsonl", "mechanism.toml", "report.json", "residual.json"]
CODES = {Grade.A: 0, Grade.B: 0, Grade.C: 5, Grade.FAILED: 5}
LOST = Reason(cause=Cause.NOT_FOLLOWED, text="Record sweep is not followed at 3 s.", next_command="mechid check bench")


@pytest.fixture(scope="module")
def fitted(request, tmp_path_factory):
    """Return nothing yet: the real run's result and folder are made by the first test that asks."""
    return {}


@pytest.fixture
def real(fitted, run, staged, tmp_path_factory):
    """Return the result and the folder of one real identification, run once."""
    if not fitted:
        out = tmp_path_factory.mktemp("fit") / "deep" / "result"
        fitted.update(result=run("identify", staged, "--out", out, "--workers", 2), out=out)
    return SimpleNamespace(**fitted)


def test_it_leaves_its_files_and_nothing_beside(real):
    assert real.result.exit_code == 0, real.result.stderr
    assert sorted(path.name for path in real.out.iterdir()) == FILES


def test_the_gear_is_found(real):
    """From 10 % off in stiffness and 23 % in damping to the bench's own values, within 5 sigma."""
    parameters = json.loads((real.out / "estimate.json").read_text())["parameters"]
    for name in ("gear.stiffness", "gear.damping"):
        found = parameters[name]
        assert abs(found["value"] - TRUTH[name]) <= 5.0 * found["std_error"]
        assert found["std_error"] < 0.01 * TRUTH[name]


def test_the_provenance_names_each_record_file_and_what_was_done_to_it(real, staged):
    records = json.loads((real.out / "estimate.json").read_text())["provenance"]["records"]
    assert records["full_46"]["file"] == "full_46.csv"
    assert records["full_46"]["sha256"] == hashlib.sha256((staged / "full_46.csv").read_bytes()).hexdigest()
    assert records["full_46"]["channels"]["torque"]["column"] == "torque_Nm"
    assert records["full_46"]["conditioning"] == []


def test_the_mechanism_file_holds_the_estimate(real):
    parameters = json.loads((real.out / "estimate.json").read_text())["parameters"]
    read = load_mechanism(real.out / "mechanism.toml")
    assert {name: read.value(name) for name in read.parameters} == {n: p["value"] for n, p in parameters.items()}


def test_results_go_to_stdout_and_progress_to_stderr(real):
    assert "stage 1 of 1: stage 1" in real.result.stderr
    assert "stage 1 of 1" not in real.result.stdout
    synthetic, grade, outcome = real.result.stdout.splitlines()[:3]
    assert synthetic.startswith("SYNTHETIC")
    assert grade.startswith(GRADE_WORDS[Grade.A])
    assert outcome == FitOutcome.STAGES_DONE.value
    assert all(f"written: {real.out / name}" in real.result.stdout.splitlines() for name in FILES)


def test_the_journal_has_a_line_for_each_stage_and_says_where_the_search_stands(real):
    lines = [json.loads(line) for line in (real.out / "journal.jsonl").read_text().splitlines()]
    standing = [line for line in lines if line["event"] == "progress"]
    assert [line["stage"] for line in standing] == ["stage 1"] * len(standing)
    assert all(set(line["values"]) == {"gear.stiffness", "gear.damping"} for line in standing)
    assert standing
    lines = [line for line in lines if line["event"] != "progress"]
    assert [line["event"] for line in lines] == ["started", "step", "stage", "finished"]
    assert lines[1]["step"] == "joint fit"
    assert lines[2]["stage"] == "stage 1"
    assert lines[3]["outcome"] == "stages_done"


@pytest.fixture
def ended(monkeypatch, staged, without_reports):
    """Return a function that makes identify end in a given way."""
    from mechid.campaign import load_campaign

    fit = identify(load_campaign(staged), workers=1)

    def end(**changes):
        from dataclasses import replace

        monkeypatch.setattr(identification, "search", lambda *_, **__: replace(fit, **changes))

    return end


def test_each_grade_has_its_exit_code_and_leaves_the_files(run, ended, staged, tmp_path):
    for grade, code in CODES.items():
        ended(grade=grade, reasons=(LOST,))
        out = tmp_path / grade
        result = run("identify", staged, "--out", out)
        assert result.exit_code == code, grade
        content = json.loads((out / "estimate.json").read_text())
        assert (content["grade"], content["grade_reasons"][0]["text"]) == (grade, LOST.text)
        assert sorted(path.name for path in out.iterdir()) == WITHOUT_REPORT
        said = [line for line in result.stderr.splitlines() if line.startswith("mechid: ")]
        wanted = (
            f"mechid: error: {GRADE_WORDS[grade]} {LOST.text} Next: {LOST.next_command}. {out} holds what was reached"
        )
        assert said == ([] if grade.good else [wanted])


def test_what_was_interrupted_has_an_exit_code_of_its_own(run, ended, staged, tmp_path):
    ended(grade=Grade.FAILED, outcome=FitOutcome.INTERRUPTED)
    assert run("identify", staged, "--out", tmp_path / "out").exit_code == 130
