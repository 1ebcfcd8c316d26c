"""Truth: what was written reads back to what was handed over."""

import json

import pytest

import mechid.writing
from mechid.campaign import load_mechanism
from mechid.errors import UsageError
from mechid.identification.result.estimate_file import read_estimate
from mechid.reports.numbers import report_data
from mechid.reports.results import write_results


def test_the_files_read_back(make_fit, truth, tmp_path):
    fit = make_fit()
    data = report_data(fit, truth)
    folder = tmp_path / "deep" / "result"
    files = write_results(fit, data, folder)
    assert sorted(path.name for path in files) == ["estimate.json", "mechanism.toml", "report.json"]
    assert sorted(folder.iterdir()) == sorted(files)
    assert read_estimate(folder / "estimate.json")["parameters"]["gear.stiffness"]["value"] == 912.97
    assert json.loads((folder / "report.json").read_text())["outcome"] == data["outcome"]
    read = load_mechanism(folder / "mechanism.toml")
    assert {q.name: q.value for q in read.free} == {q.name: q.value for q in fit.mechanism.free}


def test_a_synthetic_result_says_so_in_its_mechanism_file(make_fit, truth, tmp_path):
    fit = make_fit()
    write_results(fit, report_data(fit, truth, synthetic=True), tmp_path, mechanism_name="estimated.toml")
    assert (tmp_path / "estimated.toml").read_text().startswith("# SYNTHETIC")


def test_earlier_results_stay_where_the_new_are_not_whole(make_fit, tmp_path, monkeypatch):
    fit = make_fit()
    data = report_data(fit)
    files = write_results(fit, data, tmp_path)
    before = {path: path.read_bytes() for path in files}
    write = mechid.writing._write

    def full_disk(path, text):
        if "estimate" in path.name:
            raise OSError(28, "No space left on device")
        write(path, text)

    monkeypatch.setattr(mechid.writing, "_write", full_disk)
    with pytest.raises(UsageError, match="No space left"):
        write_results(fit, data | {"notes": ["new"]}, tmp_path)
    assert {path: path.read_bytes() for path in files} == before
    assert sorted(tmp_path.iterdir()) == sorted(files)


def test_a_folder_that_cannot_be_made_is_refused(make_fit, tmp_path):
    (tmp_path / "file").write_text("")
    fit = make_fit()
    with pytest.raises(UsageError, match="cannot be written to"):
        write_results(fit, report_data(fit), tmp_path / "file" / "result")


def test_the_validation_stands_under_each_record_and_leaves_the_rest(make_fit, validation, tmp_path):
    """Truth: the contract of estimate.json: existing keys unchanged."""
    fit = make_fit()
    write_results(fit, report_data(fit), tmp_path)
    before = read_estimate(tmp_path / "estimate.json")
    write_results(fit, report_data(fit), tmp_path, validation=validation)
    after = read_estimate(tmp_path / "estimate.json")
    torque = [record.pop("validation")["channels"]["torque"] for record in after["records"].values()]
    assert after == before
    assert [channel["theil"]["coefficient"] for channel in torque] == [0.0182, 0.0182]
    assert torque[0]["orders"][0]["phase_error_deg"] is None
