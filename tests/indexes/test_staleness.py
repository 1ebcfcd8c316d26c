"""Results that are out of date. Truth: which file was changed, taken away or written again as it was."""

import json
import os
import shutil

import pytest

import mechid
from results_by_hand import write, write_budget, write_campaign, write_fit


@pytest.fixture
def bench(tmp_path):
    """Return a folder with a campaign, and a fit of it in a folder of its own."""
    inputs = write_campaign(tmp_path / "bench")
    digest = write_fit(tmp_path / "fit", tmp_path / "bench" / "campaign.toml", inputs=inputs)
    write_budget(tmp_path / "budget", digest)
    return tmp_path


def cautions(folder, kind="Fits"):
    return [one.cautions for one in mechid.open_results(folder).entries if one.kind == kind]


def test_a_file_that_is_written_again_as_it_was_makes_nothing_stale(bench):
    """Truth: the digests; only the times differ."""
    record = bench / "bench" / "data" / "a.csv"
    record.write_bytes(record.read_bytes())
    os.utime(record, (2e9, 2e9))
    assert cautions(bench) == [()]
    assert cautions(bench, "Budgets") == [()]


@pytest.mark.parametrize("name", ["campaign.toml", "mechanism.toml", "data/a.csv"])
def test_each_file_that_a_fit_was_made_of_counts(bench, name):
    file = bench / "bench" / name
    before = file.stat()
    write(file, file.read_text(encoding="utf-8") + "\n")
    os.utime(file, (before.st_atime, before.st_mtime))  # an older time hides nothing
    assert cautions(bench) == [(f"stale: {file.name} changed since; identify anew",)]
    assert cautions(bench, "Budgets") == [("stale: its fit is",)]


def test_a_record_that_is_gone_is_said_and_is_not_called_stale(bench):
    (bench / "bench" / "data" / "a.csv").unlink()
    assert cautions(bench) == [("a.csv: not there any more",)]


def test_a_campaign_that_is_gone_tells_nothing(bench):
    shutil.rmtree(bench / "bench")
    assert cautions(bench) == [()]


def test_a_mechanism_file_that_was_edited_in_the_fit_is_said(bench):
    write(bench / "fit" / "mechanism.toml", "[gear]\nratio = 51\n")
    assert len(cautions(bench)[0]) == 1
    assert "not as identify left it" in cautions(bench)[0][0]


def test_a_budget_of_a_fit_that_was_made_anew_is_stale(bench):
    inputs = write_campaign(bench / "bench")
    write_fit(bench / "fit_2", bench / "bench" / "campaign.toml", inputs=inputs)
    assert cautions(bench, "Budgets") == [()]
    shutil.rmtree(bench / "fit")
    assert "identified anew since" in cautions(bench, "Budgets")[0][0]


def test_a_budget_that_does_not_name_its_fit_is_not_judged(bench):
    write_budget(bench / "budget", None)
    assert cautions(bench, "Budgets") == [()]


def test_a_comparison_is_stale_where_one_of_its_fits_was_made_anew(bench):
    digest = json.loads((bench / "fit" / "estimate.json").read_text())["provenance"]["mechanism_sha256"]
    for others, is_stale in (([digest], False), (["0" * 64], True), ([None], False)):
        fits = [{"mechanism_sha256": one} for one in (digest, *others)]
        content = {"format": "mechid-comparison/1", "provenance": {"fits": fits}}
        content |= {"outcome": {"code": "preferred", "message": "One is preferred."}, "preferred": "a"}
        write(bench / "comparison" / "comparison.json", {**content, "hypotheses": ["a", "b"], "cautions": []})
        (found,) = cautions(bench, "Comparisons")
        assert bool(found) is is_stale


def test_a_look_at_a_record_that_changed_is_stale(bench):
    record = bench / "bench" / "data" / "a.csv"
    one = {"name": "a", "file": str(record), "sha256": "0" * 64, "warnings": []}
    write(bench / "look" / "look.json", {"format": "mechid-look/1", "records": [one], "left_out": []})
    assert cautions(bench, "Looks") == [("stale: a.csv changed since; look again",)]


def test_a_check_of_a_record_that_changed_is_stale(bench):
    inputs = write_campaign(bench / "bench")
    provenance = {"campaign": str(bench / "bench" / "campaign.toml"), "inputs_sha256": inputs}
    content = {"format": "mechid-check/1", "records": [], "free": [], "warnings": [], "provenance": provenance}
    write(bench / "check" / "check.json", content)
    assert cautions(bench, "Checks") == [()]
    write(bench / "bench" / "data" / "a.csv", "time_s,torque_Nm\n0,1\n")
    assert cautions(bench, "Checks") == [("stale: a.csv changed since; check anew",)]


@pytest.mark.parametrize("provenance", [3, {"inputs_sha256": 3}, {"inputs_sha256": {}, "mechanism_file": "\0"}])
def test_damaged_provenance_is_said(bench, provenance):
    content = {"format": "mechid-estimate/1", "grade": "A", "grade_reasons": [], "provenance": provenance}
    write(bench / "fit" / "estimate.json", content)
    assert len(mechid.open_results(bench).entries) == 3
