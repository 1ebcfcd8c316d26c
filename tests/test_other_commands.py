"""Commands by a driver's own table and by the instants of steps, through every command that flies them.

Truth: the records, which the mechanism itself made under these commands, and the same run by `mechid.simulate`.
"""

import json

import numpy as np
import pytest
from scipy.signal import StateSpace

import mechid
from mechid.campaign import mechanism_text
from mechid.command.phase_table import nominal_table, phase_table_text
from mechid.reports.numbers import report_data
from mechid.reports.results import write_results

RATE_HZ, SECONDS, NOISE_NM = 5000.0, 0.8, 0.002
TABLE = tuple((0.95 * a + 0.05 * a**3, 0.9 * b) for a, b in nominal_table(4).tolist())
PAIRED = np.sort(np.concatenate([np.arange(1, 40) / 50.0, np.arange(1, 40) / 50.0 + 0.004]))
COMMANDS = {
    "by_table": mechid.make_command("micro", microsteps=4, rate=46.0, table=TABLE),
    "paired": mechid.make_command("full", step_times=PAIRED),
}
BODY = mechid.from_state_space(
    StateSpace([[0.0, 1.0], [-400.0, -0.4]], [[0.0], [0.1]], [[1.0, 0.0]], [[0.0]]), ("x",), has_interface=False
)
CAMPAIGN = """
mechanism = "mechanism.toml"
[[record]]
name = "by_table"
file = "by_table.csv"
command = { stepping = "micro", microsteps = 4, rate = 46.0, table = "table.csv" }
[[record]]
name = "paired"
file = "paired.csv"
command = { stepping = "full", step_times = "steps.csv" }
"""
BUDGET = """
[[mode]]
name = "quiet"
command = { stepping = "micro", microsteps = 4, rate = 46.0, table = "table.csv" }
[[mode]]
name = "stepped"
command = { stepping = "full", step_times = "steps.csv" }
[[requirement]]
name = "jitter"
index = "APE"
axis = "x"
limit_rad = 1e-4
interpretation = "temporal"
confidence = 0.95
evaluation_period_s = 600.0
[[requirement]]
name = "lines"
direction = "torque"
kind = "amplitude"
unit = "N*m"
mask = [[10.0, 1.0], [400.0, 1.0]]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a campaign with both commands in files, and its fit in ``fit``."""
    here = tmp_path_factory.mktemp("commands")
    mechanism = mechid.catalogue_mechanism().with_free(("gear.stiffness", "gear.damping"))
    planned = mechid.make_campaign(mechanism, [mechid.make_record(n, command=c) for n, c in COMMANDS.items()])
    for name in COMMANDS:
        run = mechid.simulate(planned, name, sample_rate_hz=RATE_HZ, duration_s=SECONDS)
        noisy = run.torque + NOISE_NM * np.random.default_rng(3).standard_normal(run.time.size)
        rows = np.column_stack([run.time, noisy])
        np.savetxt(here / f"{name}.csv", rows, delimiter=",", header="time_s,torque_Nm", comments="")
    (here / "table.csv").write_text(phase_table_text(TABLE))
    (here / "steps.csv").write_text("time_s\n" + "\n".join(map(repr, PAIRED.tolist())) + "\n")
    (here / "mechanism.toml").write_text(mechanism_text(mechanism))
    (here / "campaign.toml").write_text(CAMPAIGN)
    (here / "budget.toml").write_text(BUDGET)
    campaign = mechid.load_campaign(here)
    near = {name: 1.001 * mechanism.value(name) for name in ("gear.stiffness", "gear.damping")}
    fit = mechid.identify(campaign, workers=1, near=near)
    write_results(fit, report_data(fit), here / "fit")
    return here


def test_the_files_give_the_commands(folder):
    campaign = mechid.load_campaign(folder)
    assert {record.name: record.command for record in campaign.records} == COMMANDS


@pytest.fixture(scope="module")
def fit(folder):
    return mechid.load_fit(folder / "fit", mechid.load_campaign(folder))


def test_the_fit_finds_the_values_that_made_the_records(fit):
    mechanism = mechid.catalogue_mechanism()
    assert fit.grade == "A"
    free = {name: one for name, one in fit.parameters.items() if one.std_error}
    assert set(free) == {"gear.stiffness", "gear.damping"}
    for name, one in free.items():
        assert abs(one.value - mechanism.value(name)) < 4.0 * one.std_error


def test_it_is_said_how_the_phases_are_set(folder):
    assert "by a table of 16 values" in json.dumps(mechid.check(folder).to_dict())


def test_exports_fly_both(fit, tmp_path):
    """Truth: the kernel's own run under the records' commands, with which an export compares itself."""
    mechid.export(fit, to="c", out=tmp_path, campaign=fit.campaign)
    checked = json.loads((tmp_path / "mechid_export.json").read_text())["checked"]
    assert checked is None or 0.0 < checked["largest_error"] < 1e-6


def test_a_budget_flies_both(folder, fit, tmp_path):
    """Truth: the cosine's own table gives the cosine's budget; this one gives another."""
    text = (folder / "budget.toml").read_text()
    (tmp_path / "table.csv").write_text(phase_table_text(nominal_table(4).tolist()))
    (tmp_path / "steps.csv").write_text((folder / "steps.csv").read_text())
    (tmp_path / "nominal.toml").write_text(text)
    (tmp_path / "cosine.toml").write_text(text.replace(', table = "table.csv"', ""))
    files = {"shaped": folder / "budget.toml", "nominal": tmp_path / "nominal.toml", "cosine": tmp_path / "cosine.toml"}
    modes = {name: mechid.budget(file, fit=fit, structure=BODY).to_dict()["modes"] for name, file in files.items()}
    rms = {name: [mode["torque_rms_Nm"] for mode in found] for name, found in modes.items()}
    assert rms["nominal"] == pytest.approx(rms["cosine"], rel=1e-9)
    assert abs(rms["shaped"][0] / rms["cosine"][0] - 1.0) > 0.05
    assert rms["shaped"][1] == rms["cosine"][1] > 0.0
