"""A fit in memory and the same fit in a folder. Truth: each gives what the other does."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import StateSpace

import mechid
from mechid.analysis.fit_residuals import FitResiduals
from mechid.identification.result.estimate_file import json_text
from mechid.identification.result.fit_file import read_fit
from mechid.reports.numbers import report_data
from mechid.reports.results import write_results
from synthetic import AS_WRITTEN

RATE_HZ, SECONDS, NOISE_NM = 5000.0, 0.8, 0.002
COMMANDS = {name: mechid.make_command("full", rate=rate) for name, rate in (("full_46", 46.0), ("full_60", 60.0))}
BODY = mechid.from_state_space(
    StateSpace([[0.0, 1.0], [-400.0, -0.4]], [[0.0], [0.1]], [[1.0, 0.0]], [[0.0]]), ("x",), has_interface=False
)
BUDGET = {
    "mode": [{"name": "slew", "command": {"stepping": "full", "rate": 50.0}}],
    "requirement": [
        {
            "name": "jitter",
            "index": "APE",
            "axis": "x",
            "limit_rad": 1e-4,
            "interpretation": "temporal",
            "confidence": 0.95,
            "evaluation_period_s": 600.0,
        },
        {
            "name": "lines",
            "direction": "torque",
            "kind": "amplitude",
            "unit": "N*m",
            "mask": [[10.0, 1.0], [400.0, 1.0]],
        },
    ],
}
BENCH = """
mechanism = "none.toml"
[[record]]
name = "full_46"
file = "full_46.npy"
sample_rate_hz = 5000.0
command = { stepping = "full", rate = 46.0 }
channels = [{ quantity = "torque", column = 0, unit = "N*m" }]
[[requirement]]
name = "lines"
direction = "torque"
kind = "amplitude"
unit = "N*m"
mask = [[10.0, 1.0], [400.0, 1.0]]
"""


@pytest.fixture(scope="module")
def fit():
    """Return a fit of records with a line that its mechanism lacks, so that residuals fly."""
    mechanism = mechid.catalogue_mechanism().with_free(("gear.stiffness", "gear.damping"))
    planned = [mechid.make_record(name, command=command) for name, command in COMMANDS.items()]
    bench = mechid.make_campaign(mechanism, planned)
    rng = np.random.default_rng(3)
    records = []
    for name, command in COMMANDS.items():
        run = mechid.simulate(bench, name, sample_rate_hz=RATE_HZ, duration_s=SECONDS)
        missing = 0.01 * np.cos(2.0 * np.pi * 2.0 * command.rate.rates[0] * run.time + 0.3)
        torque = run.torque + missing + NOISE_NM * rng.standard_normal(run.time.size)
        use = "estimate" if name == "full_46" else "validate"
        records.append(mechid.make_record(name, torque, sample_rate_hz=RATE_HZ, command=command, use=use))
    campaign = replace(mechid.make_campaign(mechanism, records, name="bench"), options=AS_WRITTEN)
    near = {name: mechanism.value(name) for name in ("gear.stiffness", "gear.damping")}
    return mechid.identify(campaign, workers=1, near=near)


@pytest.fixture(scope="module")
def folder(fit, tmp_path_factory):
    """Return the folder in which identify leaves that fit."""
    validation = mechid.validate(fit.campaign, fit)
    left = tmp_path_factory.mktemp("fit")
    write_results(fit, report_data(fit, validation=validation), left, validation=validation)
    return left


def budget(fit, campaign, out):
    made = mechid.budget(BUDGET, fit=fit, structure=BODY)
    assert made.estimate.residual is not None
    found = json.loads(json_text(made.to_dict()))
    assert found.pop("estimate").endswith("estimate.json")
    assert found.pop("provenance")  # a fit in memory is not signed
    return found


def emission(fit, campaign, out):
    out.mkdir()
    np.save(out / "full_46.npy", campaign.records[0].data.channels[0].data[:][:, None])
    (out / "campaign.toml").write_text(BENCH)
    found = json.loads(json_text(mechid.emission(out, fit=fit).to_dict()))
    assert found["prediction"].pop("fit")
    found["prediction"].pop("mechanism_sha256")  # of a file, which a fit in memory does not have
    assert found["requirements"][0]["predicted"]["at_rates"]
    return {key: found[key] for key in ("requirements", "prediction", "notes")}


def compare(fit, campaign, out):
    found = json.loads(json_text(mechid.compare(fit, mechid.load_fit(out.parent / "other", campaign)).to_dict()))
    assert len(found.pop("hypotheses")) == len(found["scores"]) == 2
    for score in found["scores"]:
        del score["name"], score["hypothesis"]
    return {key: found[key] for key in ("scores", "records", "parameters", "cautions", "spectra")}


def export(fit, campaign, out):
    options = {"rates": "46"}
    done = mechid.export(fit, to="tables", out=out, campaign=campaign, options=options)
    tables = {name: (out / name).read_text() for name in done.written.files if name.endswith(".csv")}
    assert {"parameters.csv", "records.csv"} <= tables.keys()
    assert tables.pop("provenance.csv")
    return tables | {"words": list(done.written.words)}


@pytest.mark.parametrize(
    "made", [*(pytest.param(one, marks=pytest.mark.slow) for one in (budget, compare)), emission, export]
)
def test_results_do_not_depend_on_where_the_fit_is(made, fit, folder, tmp_path):
    """In memory, from the folder by its path, and loaded with the campaign."""
    write_results(fit, report_data(fit), tmp_path / "other", validation=mechid.validate(fit.campaign, fit))
    loaded = mechid.load_fit(folder, fit.campaign)
    forms = {"memory": fit, "folder": folder, "loaded": loaded}
    found = {name: made(form, fit.campaign, tmp_path / name) for name, form in forms.items()}
    assert found["folder"] == found["memory"]
    assert found["loaded"] == found["memory"]


def test_a_fit_in_memory_leaves_no_file(fit, monkeypatch):
    monkeypatch.setattr("tempfile.mkdtemp", None)
    mechid.compare(fit, fit, names=("a", "b"))
    mechid.budget(BUDGET, fit=fit, structure=BODY)


def test_a_fit_without_its_campaign_has_no_residuals(fit):
    alone = mechid.Fit(**{**vars(fit), "campaign": None})
    with pytest.raises(mechid.UsageError, match="does not hold its campaign"):
        mechid.budget(BUDGET, fit=alone, structure=BODY)
    with pytest.raises(mechid.UsageError, match="does not hold its campaign"):
        mechid.compare(alone, alone)


def test_without_residual_json_it_is_computed_where_the_campaign_is_there(fit, folder, tmp_path):
    for name in ("estimate.json", "mechanism.toml"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    assert FitResiduals(read_fit(tmp_path)).torques is None
    (computed,) = FitResiduals(mechid.load_fit(tmp_path, fit.campaign)).torques[:1]
    (read,) = FitResiduals(read_fit(folder)).torques[:1]
    assert (computed.name, computed.noise_sigma) == (read.name, read.noise_sigma)
    np.testing.assert_array_equal(computed.rates[0].amplitude, read.rates[0].amplitude)


def test_fits_compare_whose_mechanism_files_have_changed(folder, tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "estimate.json").write_bytes((folder / "estimate.json").read_bytes())
    assert len(mechid.compare(tmp_path / "a", tmp_path / "b").scores) == 2
    with pytest.raises(mechid.InputFileError, match="there is no such file"):
        read_fit(tmp_path / "a")


def test_a_comparison_loads_few_modules():
    """It needs no simulator, no search and no report; 50 of mechid's modules at present."""
    program = "import sys, mechid; mechid.compare; print(*(name for name in sys.modules if name.startswith('mechid.')))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    loaded = done.stdout.split()
    assert len(loaded) <= 60
    heavy = ("kernel", "simulation", "reports", "campaign", "identification.search", "identification.output_error")
    assert not [name for name in loaded if name.startswith(tuple(f"mechid.{part}" for part in heavy))]
