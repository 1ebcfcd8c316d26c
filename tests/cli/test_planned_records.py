"""Records without a file. Truth: docs/files.md, one rule for check, simulate and design; the others need the file."""

import json
import shutil

import numpy as np
import pytest

from small_design import shorten_loss_table

CAMPAIGN = """
mechanism = "mechanism.toml"
[[record]]
name = "constant"
command = { stepping = "full", rate = 46.0, start_angle_deg = 45.0 }
[[record]]
name = "sweep"
command = { stepping = "micro", microsteps = 16, rate_profile = [[0.0, 0.0], [1.5, 30.0]] }
[[record]]
name = "own_rate"
sample_rate_hz = 4000.0
command = { stepping = "full", rate = 23.0, start_angle_deg = 45.0 }
"""
DESIGN = """
[recording]
noise_Nm = 0.002
[candidates]
steppings = ["full"]
rates = [46.0]
start_angles_deg = [45.0]
sweeps_s = []
[prior]
mechanisms = 1
"""
LASTS = {"constant": (1.0, 10_000.0), "sweep": (1.5, 10_000.0), "own_rate": (1.0, 4000.0)}
"""A second, or to the end of the rate profile; at the record's own rate, or 10 kHz."""


@pytest.fixture
def planned(bench, tmp_path):
    """Return a folder with a campaign of three records, none of which has been taken."""
    shutil.copy(bench / "mechanism.toml", tmp_path)
    (tmp_path / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    (tmp_path / "design.toml").write_text(DESIGN, encoding="utf-8")
    return tmp_path


def test_check_simulate_and_design_take_them_alike(run, planned, monkeypatch):
    shorten_loss_table(monkeypatch)
    checked = run("check", planned)
    assert checked.exit_code == 0, checked.stderr
    simulated = run("simulate", planned, "--out", planned / "sim")
    assert simulated.exit_code == 0, simulated.stderr
    designed = run("design", planned, "--out", planned / "next")
    assert designed.exit_code == 0, designed.stderr
    data = json.loads((planned / "next" / "design.json").read_text(encoding="utf-8"))
    seconds = {r["name"]: r["duration_s"] for r in data["candidates"]}
    for name, (lasts, rate) in LASTS.items():
        said = f"counts for {lasts:g} s at {rate:g} Hz by simulate and design"
        assert said in checked.stdout
        assert f'record "{name}" has no file: simulated for {lasts:g} s at {rate:g} Hz' in simulated.stderr
        time = np.loadtxt(planned / "sim" / f"{name}.csv", delimiter=",", skiprows=1)[:, 0]
        np.testing.assert_allclose(time, np.arange(round(lasts * rate) + 1) / rate, atol=1e-12)
        assert seconds[name] == lasts


def test_what_compares_with_measurements_refuses_them(refused, planned):
    line = refused(3, "identify", planned, "--out", planned / "fit")
    assert "record[0].file: missing; write the name of the measured file" in line


def misspell(planned):
    """Name a file of the sweep that is not there."""
    path = planned / "campaign.toml"
    named = path.read_text(encoding="utf-8").replace('name = "sweep"', 'name = "sweep"\nfile = "swep.csv"')
    path.write_text(named, encoding="utf-8")


def test_a_file_that_is_named_has_to_be_there(refused, planned):
    misspell(planned)
    assert "swep.csv: there is no such file" in refused(4, "check", planned)
    assert "swep.csv: there is no such file" in refused(4, "simulate", planned, "--out", planned / "sim")


@pytest.mark.slow
def test_design_goes_on_without_the_file_of_a_record_and_says_so(run, planned):
    """The campaign that it proposes names files to be taken."""
    misspell(planned)
    result = run("design", planned, "--out", planned / "next")
    assert result.exit_code == 0, result.stderr
    assert 'record "sweep": swep.csv is not there: it counts as planned' in result.stdout


@pytest.mark.parametrize("verb", ["check", "simulate", "design"])
def test_a_record_that_measured_channels_drive_needs_its_file(refused, planned, verb):
    path = planned / "campaign.toml"
    head = path.read_text(encoding="utf-8").partition("[[record]]")[0]
    channels = """channels = [ { quantity = "torque", column = "Mz" },
    { quantity = "voltage_phase_a", column = "ua", role = "input" },
    { quantity = "voltage_phase_b", column = "ub", role = "input" } ]"""
    path.write_text(f'{head}[[record]]\nname = "driven"\n{channels}\n', encoding="utf-8")
    out = [] if verb == "check" else ["--out", planned / "out"]
    assert 'record[0].file: missing; channels of role = "input" drive the record' in refused(3, verb, planned, *out)
