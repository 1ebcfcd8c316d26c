"""Test report of a fit. Truth: report.json and estimate.json, and the campaign that was identified."""

import json
from dataclasses import replace

import pytest

from mechid.campaign.declared_test import DeclaredTest
from mechid.ink.document import Document
from mechid.ink.in_markdown import document_markdown
from mechid.reports.verification import MET, NOT_MET, fit_report

DECLARED = DeclaredTest(article={"name": "SADM-200"}, deviations=("No run at 90 steps/s.",))


@pytest.fixture(scope="module")
def contents(reported):
    return json.loads((reported.folder / "report.json").read_text(encoding="utf-8"))


def written(contents, reported):
    campaign = replace(reported.campaign, test=DECLARED)
    empty = Document(title="", command="mechid report")
    return document_markdown(fit_report(contents, campaign, empty, {"estimate.json": 64 * "e"}))


def rows_of(text, heading):
    """Return the cells of the first table under a heading."""
    lines = text.split(f"## {heading}\n")[1].split("\n## ")[0].splitlines()
    table = [line for line in lines if line.startswith("|")]
    return [[cell.strip(" *").replace("\\", "") for cell in line.strip("|").split("|")] for line in table[2:]]


def test_each_record_is_held_against_its_noise(contents, reported):
    rows = {row[0]: row for row in rows_of(written(contents, reported), "Verification")}
    assert rows["the fit may be relied on"][2:] == [
        f"grade {contents['grade']}",
        "grade A or B",
        "",
        MET,
        f"estimate.json, sha256 {16 * 'e'}…",
    ]
    ratios = {row["name"]: row["noise_ratio"] for row in contents["record_table"]}
    for name, words in (("full_46", "explained"), ("sweep", "predicted, held out of the fit,")):
        row = rows[f"{name}: {words} down to the noise"]
        assert row[2] == f"{ratios[name]:.3g} times the noise"
        assert row[5] == MET


def test_a_residual_above_the_noise_and_an_unknown_parameter_are_not_met(contents, reported):
    changed = json.loads(json.dumps(contents))
    for row in changed["validation"]:
        row["residual_rms"] *= 3.0
    next(row for row in changed["parameters"] if row["std_error"])["std_error"] = None
    rows = rows_of(written(changed, reported), "Verification")
    verdicts = {row[0].split(":")[0]: row[5] for row in rows}
    assert verdicts == {
        "the fit may be relied on": MET,
        "free parameters are identified": NOT_MET,
        "full_46": NOT_MET,
        "sweep": NOT_MET,
    }


def test_noise_records_and_deviations_are_those_of_the_fit(contents, reported):
    text = written({**contents, "warnings": ["a warning"], "missing": []}, reported)
    noise = rows_of(text, "Noise")
    assert [row[0] for row in noise] == ["full_46", "sweep"]
    assert [row[2] for row in noise] == [row["text"]["noise_known"] for row in contents["records"]]
    assert [row[4] for row in noise] == [row["noise_rests_on"] for row in contents["records"]]
    runs = rows_of(text, "Records")
    assert [row[:2] for row in runs[:2]] == [["full_46", "estimate"], ["sweep", "validate"]]
    assert "- No run at 90 steps/s." in text
    assert "- a warning" in text
    assert "SADM-200" in text


def test_without_a_record_held_out_the_prediction_is_not_tested(contents, reported):
    own = [{**row, "use": "estimate"} for row in contents["validation"]]
    text = written({**contents, "validation": own}, reported)
    assert rows_of(text, "Verification")[-1][5] == "not tested"
    assert "- No record was held out of the fit" in text
