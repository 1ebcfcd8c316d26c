"""A fit read back; truth: the fit that was written."""

import json
from dataclasses import fields, replace

import numpy as np
import pytest

from mechid.campaign import load_campaign
from mechid.campaign.bench import write_bench
from mechid.errors import InputFileError
from mechid.identification.identify import identify
from mechid.identification.output_error.declaration import Reading
from mechid.identification.result.estimate_file import estimate_text, write_estimate
from mechid.identification.result.fit_file import read_fit, read_numbers
from mechid.identification.result.record_result import MaskedMoment
from mechid.reports.numbers import report_data
from mechid.reports.results import write_results

STAGE = """
[[stage]]
records = ["full_46"]
window_s = [0.0, 0.03]
free = ["gear.stiffness", "gear.damping"]
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    write_bench(folder, seed=3, sweep_s=1.0)
    with (folder / "campaign.toml").open("a") as file:
        file.write(STAGE)
    campaign = load_campaign(folder)
    fit = identify(campaign, workers=1)
    write_estimate(fit, folder / "estimate.json")
    return folder, campaign, fit


def test_it_reads_back_to_what_was_written(made):
    folder, _, fit = made
    read = read_fit(folder / "estimate.json", load_campaign(folder))
    assert estimate_text(read) == estimate_text(fit)
    assert read.mechanism.kernel_values().tolist() == fit.mechanism.kernel_values().tolist()
    other = {f.name for f in fields(read) if type(getattr(read, f.name)) is not type(getattr(fit, f.name))}
    assert other == {"folder"}
    assert read.folder == folder


def test_masked_moments_read_back(made, tmp_path):
    _, campaign, fit = made
    moment = MaskedMoment(first=3, stop=9, from_s=0.3, to_s=0.9, largest=0.1, over_noise=50.0, chi_square=4e3)

    def left_out(record):
        channels = {name: replace(c, masked=(moment,)) for name, c in record.channels.items()}
        return replace(record, channels=channels)

    some = replace(fit, records={n: left_out(r) for n, r in fit.records.items()})
    write_estimate(some, tmp_path / "estimate.json")
    read = read_fit(tmp_path / "estimate.json", campaign)
    assert {n: r.masked for n, r in read.records.items()} == dict.fromkeys(fit.records, (moment,))


def test_what_is_no_number_stays_none(made, tmp_path):
    _, campaign, fit = made
    lost = replace(fit, records={n: replace(r, fit_percent=np.nan) for n, r in fit.records.items()})
    write_estimate(lost, tmp_path / "estimate.json")
    read = read_fit(tmp_path / "estimate.json", campaign)
    assert all(np.isnan(r.fit_percent) for r in read.records.values())


@pytest.mark.parametrize("name", ["campaign.toml", "mechanism.toml", "full_46.csv"])
def test_changed_files_are_refused(made, name):
    folder, campaign, _ = made
    path = folder / name
    before = path.read_bytes()
    try:
        path.write_bytes(before + b"\n")
        with pytest.raises(InputFileError, match=rf"{name} is not the file that was identified"):
            read_fit(folder / "estimate.json", campaign)
    finally:
        path.write_bytes(before)


@pytest.mark.parametrize("key", ["parameters", "records", "provenance", "outcome"])
def test_a_damaged_file_is_refused(made, tmp_path, key):
    folder, campaign, _ = made
    content = json.loads((folder / "estimate.json").read_text())
    del content[key]
    (tmp_path / "estimate.json").write_text(json.dumps(content))
    with pytest.raises(InputFileError, match="is damaged"):
        read_fit(tmp_path / "estimate.json", campaign)


def test_how_a_record_was_taken_reads_back(made, tmp_path):
    _, campaign, fit = made
    taken = Reading(
        polarity=-1, direction=-1, start_angle_deg=12.5, time_offset_s=(0.001, -0.002, 0.002), left_out=True
    )
    other = replace(fit, records=fit.records | {"full_46": replace(fit.records["full_46"], reading=taken)})
    write_estimate(other, tmp_path / "estimate.json")
    assert read_fit(tmp_path / "estimate.json", campaign).records["full_46"].reading == taken


@pytest.fixture(scope="module")
def left(made, tmp_path_factory):
    """Return the folder in which identify leaves the fit, its mechanism file beside its estimate."""
    folder = tmp_path_factory.mktemp("left")
    write_results(made[2], report_data(made[2]), folder)
    return folder


def test_without_its_campaign_a_fit_reads_back_too(made, left):
    _, campaign, fit = made
    read = read_fit(left)
    assert estimate_text(read) == estimate_text(read_fit(left / "estimate.json"))
    assert estimate_text(read) == estimate_text(read_fit(left, campaign))
    assert replace(read, provenance=fit.provenance).to_dict() == fit.to_dict()
    assert read.mechanism.kernel_values().tolist() == fit.mechanism.kernel_values().tolist()
    assert list(read.mechanism.parameters) == list(fit.mechanism.parameters)
    assert [p.name for p in read.mechanism.free] == [p.name for p in fit.mechanism.free]
    assert (read.folder, read.campaign) == (left, None)


def test_without_its_campaign_another_mechanism_file_is_refused(left, tmp_path):
    (tmp_path / "estimate.json").write_bytes((left / "estimate.json").read_bytes())
    with pytest.raises(InputFileError, match=r"mechanism\.toml: there is no such file; identify writes it beside"):
        read_fit(tmp_path)
    (tmp_path / "mechanism.toml").write_bytes((left / "mechanism.toml").read_bytes() + b"\n")
    with pytest.raises(InputFileError, match="is not the file that identify wrote beside"):
        read_fit(tmp_path)


def test_without_its_campaign_an_estimate_that_names_no_mechanism_file_is_refused(made):
    folder, _, _ = made
    with pytest.raises(InputFileError, match=r"provenance\.mechanism_sha256: missing; an earlier mechid wrote it"):
        read_fit(folder)


def test_an_estimate_whose_grade_is_of_another_model_is_refused(made, tmp_path):
    """Truth: the table ``beside`` as an earlier version wrote it; null where no terms were added."""
    folder, _, _ = made
    content = json.loads((folder / "estimate.json").read_text())
    term = {"value": 0.005, "std_error": 5e-5, "unit": "1", "width": None, "term": "t", "meaning": "amplitude"}
    beside = {"names": ["t"], "words": {"t": "a term"}, "parameters": {"stepper.torque_harmonic.0.amplitude": term}}
    path = tmp_path / "estimate.json"
    path.write_text(json.dumps(content | {"beside": beside}))
    with pytest.raises(InputFileError, match=r"estimate\.json: beside: an earlier version graded .* identify anew"):
        read_numbers(path)
    with pytest.raises(InputFileError, match="beside"):
        read_fit(path, load_campaign(folder))
    path.write_text(json.dumps(content | {"beside": None}))
    assert read_numbers(path).grade == content["grade"]


def test_a_folder_without_an_estimate_is_refused(tmp_path):
    with pytest.raises(InputFileError, match=r'estimate\.json: there is no such file; "mechid identify" writes it'):
        read_fit(tmp_path / "nowhere")
