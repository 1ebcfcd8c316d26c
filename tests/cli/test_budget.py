"""``mechid budget`` from an estimate to its files; the numbers on the terminal are those in the files."""

import csv
import json
import re

import numpy as np
import pytest

from mechid.budgets.example import BUDGET, STRUCTURE, write_example
from paper_estimate import write_estimate_of_paper

WITHOUT_DUTY = re.sub(r"duty = .*\n", "", BUDGET)
ALONE = WITHOUT_DUTY[: WITHOUT_DUTY.index('[[mode]]\nname = "slew"')] + BUDGET[BUDGET.index("[[requirement]]") :]
SMALL = ALONE.replace("rate_range = { from = 10.0, to = 60.0, count = 26 }", "rates = [20.0, 47.5]").replace(
    "limit_rad = 6e-7", "limit_rad = 1e-7"
)


@pytest.fixture
def folder(tmp_path):
    write_estimate_of_paper(tmp_path, fit_percent=99.0)
    (tmp_path / "budget.toml").write_text(SMALL, encoding="utf-8")
    (tmp_path / "structure.toml").write_text(STRUCTURE, encoding="utf-8")
    return tmp_path


def test_a_budget_from_file_to_file(run, folder):
    """Truth: closed forms between the files. RMS of the line of sight is the lines' by the modes' transfer."""
    result = run("budget", folder / "budget.toml", "--out", folder / "out", "--docx")
    assert result.exit_code == 0, result.stderr
    assert f"written: {folder / 'out' / 'budget.docx'}" in result.stdout
    data = json.loads((folder / "out" / "budget.json").read_text(encoding="utf-8"))
    rows = list(csv.DictReader((folder / "out" / "harmonics.csv").read_text(encoding="utf-8").splitlines()))
    (mode,) = data["modes"]
    assert mode["worst_rate"] == 47.5
    lines = [r for r in rows if float(r["rate_steps_per_s"]) == 47.5]
    f = np.array([float(r["frequency_Hz"]) for r in lines])
    amplitude = np.array([float(r["torque_amplitude_Nm"]) for r in lines])
    w = 2.0 * np.pi * f
    wk = 2.0 * np.pi * np.array([0.02, 21.0, 47.5, 112.0])[:, None]
    zeta = np.array([0.7, 0.005, 0.005, 0.01])[:, None]
    weight = np.array([0.1, 0.15, 0.2, -0.1]) * np.array([0.1, -0.04, 0.05, 0.03])
    h = weight @ (1.0 / (wk**2 - w**2 + 2j * zeta * wk * w))
    inside = f <= 224.0  # twice the highest mode
    expected = np.sqrt(0.5 * np.sum(np.abs(h * amplitude)[inside] ** 2))
    assert mode["line_of_sight_rms_rad"][0] == pytest.approx(expected, rel=1e-6)
    assert mode["cumulative_rms_rad"]["lines"][0][-1] == pytest.approx(expected, rel=1e-6)
    bands = list(csv.DictReader((folder / "out" / "envelope.csv").read_text(encoding="utf-8").splitlines()))
    largest = max(float(r["torque_amplitude_Nm"]) for r in rows)
    assert max(float(r["torque_amplitude_Nm"]) for r in bands) == pytest.approx(largest)
    exposure = data["requirements"][0]
    assert exposure["margin"] == pytest.approx(1.0 - exposure["level_rad"] / 1e-7)
    assert not exposure["met"]
    assert sum(exposure["variance_shares"].values()) == pytest.approx(1.0)
    assert exposure["variance_shares"]["model discrepancy"] > 0.0
    assert "stability in an exposure: avoid " in result.stdout
    assert "left on the bench: [housing]: its filter has no reaction" in result.stdout


@pytest.mark.slow
def test_several_steady_states_from_file_to_file(run, folder):
    """Truth: closed forms between the files: decay by multiplier, and of a rate's motions the largest RMS counts."""
    sticky = SMALL.replace("[flight]\n", "[flight]\nvalues = { friction.static = 0.03, friction.viscous = 0.002 }\n")
    sticky = sticky.replace("rates = [20.0, 47.5]", "rates = [21.0, 24.0, 27.0, 30.0, 33.0]")
    (folder / "budget.toml").write_text(sticky, encoding="utf-8")
    result = run("budget", folder / "budget.toml", "--out", folder / "out")
    assert result.exit_code == 0, result.stderr
    (mode,) = json.loads((folder / "out" / "budget.json").read_text(encoding="utf-8"))["modes"]
    rows = list(csv.DictReader((folder / "out" / "steady_states.csv").read_text(encoding="utf-8").splitlines()))
    here = {s["reached"]: s for s in rows if float(s["rate_steps_per_s"]) == 21.0}
    worst = next(s for s in here.values() if s["worst"] == "1")
    sizes = [max(float(s["rms_x_rad"]), float(s["rms_y_rad"])) for s in here.values()]
    smooth = next(s for reached, s in here.items() if "from rest" not in reached)
    assert len(here) > 1
    assert max(float(worst["rms_x_rad"]), float(worst["rms_y_rad"])) == max(sizes)
    decay_s = -2.0 * int(smooth["periods"]) / 21.0 / np.log(float(smooth["largest_multiplier"]))
    assert float(smooth["decay_s"]) == pytest.approx(decay_s, rel=1e-8)
    told = mode["steady_states"]["several"][0]
    assert told["rate"] == 21.0
    assert [" and ".join(s["reached"]) for s in told["states"]] == list(here)
    assert "the disturbance depends on how the rate was reached" in " ".join(result.stdout.split())
    text = (folder / "out" / "budget.md").read_text(encoding="utf-8")
    assert "Rates at which there is more than one steady motion" in text
    assert "steady_states.csv" in result.stdout


def test_time_series_and_densities_in_hdf5(run, folder):
    """Truth: Parseval between a series and its density, and the RMS in budget.json."""
    h5py = pytest.importorskip("h5py")
    assert run("budget", folder / "budget.toml", "--out", folder / "out").exit_code == 0
    data = json.loads((folder / "out" / "budget.json").read_text(encoding="utf-8"))
    with h5py.File(folder / "out" / "disturbance.h5") as file:
        scan = file["scan"]
        step = scan["frequency"][1]
        assert scan["torque"].attrs["unit"] == "N*m"
        assert scan["torque_psd"][:].sum() * step == pytest.approx(np.mean(scan["torque"][:] ** 2), rel=1e-6)
        for k, axis in enumerate(("x", "y")):
            rms = data["modes"][0]["line_of_sight_rms_rad"][k]
            assert scan[f"line_of_sight_{axis}"][:].std() == pytest.approx(rms, rel=1e-6)
            assert np.sqrt(scan[f"line_of_sight_{axis}_psd"][:].sum() * step) == pytest.approx(rms, rel=1e-6)


def test_a_wrong_key_is_one_line_and_exit_code_3(refused, folder):
    text = SMALL.replace("[flight]", "[flihgt]")
    (folder / "budget.toml").write_text(text, encoding="utf-8")
    line = refused(3, "budget", folder / "budget.toml", "--out", folder / "out")
    assert 'flihgt: unknown key; did you mean "flight"' in line


def test_a_missing_estimate_says_what_writes_it(refused, folder):
    (folder / "estimate.json").unlink()
    line = refused(3, "budget", folder / "budget.toml", "--out", folder / "out")
    assert 'there is no such file; "mechid identify" writes it' in line


PROFILE = SMALL.replace(
    'command = { stepping = "micro", microsteps = 16 }\nrates = [20.0, 47.5]\n',
    'command = { stepping = "micro", microsteps = 16, rate_profile = [[0.0, 0.0], [2.0, 50.0]] }\n',
)


def test_an_estimate_without_correlation_is_refused(refused, folder):
    """Truth: exit code 3; the errors of the parameters cannot be carried to the line of sight without it."""
    estimate = json.loads((folder / "estimate.json").read_text(encoding="utf-8"))
    del estimate["correlation"]
    (folder / "estimate.json").write_text(json.dumps(estimate), encoding="utf-8")
    line = refused(3, "budget", folder / "budget.toml", "--out", folder / "out")
    assert "estimate.json: correlation: missing; the file is damaged" in line


def test_a_profile_from_file_to_file(run, folder):
    """Truth: Parseval on the series in the file, and the windows of that series."""
    h5py = pytest.importorskip("h5py")
    assert "rate_profile" in PROFILE
    (folder / "budget.toml").write_text(PROFILE, encoding="utf-8")
    result = run("budget", folder / "budget.toml", "--out", folder / "out", "--docx")
    assert result.exit_code == 0, result.stderr
    assert f"written: {folder / 'out' / 'budget.docx'}" in result.stdout
    data = json.loads((folder / "out" / "budget.json").read_text(encoding="utf-8"))
    (mode,) = data["modes"]
    rows = list(csv.DictReader((folder / "out" / "windowed.csv").read_text(encoding="utf-8").splitlines()))
    assert max(float(row["rms_x_rad"]) for row in rows) == pytest.approx(mode["line_of_sight_rms_rad"][0])
    with h5py.File(folder / "out" / "disturbance.h5") as file:
        scan = file["scan"]
        series, rate = scan["line_of_sight_x"][:], scan.attrs["line_of_sight_sample_rate_Hz"]
        step = scan["line_of_sight_frequency"][1]
        assert scan["line_of_sight_x_psd"][:].sum() * step == pytest.approx(np.mean(series**2), rel=1e-6)
        assert series.size == pytest.approx(2.0 * rate, abs=1.0)
    n = round(mode["rms_window_s"] * rate)
    last = float(rows[-1]["rms_x_rad"])
    assert last == pytest.approx(series[-n:].std(), rel=1e-6)
    assert mode["rates"] == []
    assert {row["mode"] for row in data["requirements"]} == {"scan"}


@pytest.mark.slow
def test_lines_of_the_microsteps_are_kept_or_named(run, tmp_path):
    """Truth: 16 microsteps at 47.5 steps/s switch at 760 Hz; the motion's own line of it is not small."""
    write_estimate_of_paper(tmp_path)
    text = SMALL.replace("rates = [20.0, 47.5]", "rates = [47.5]")
    (tmp_path / "budget.toml").write_text(text, encoding="utf-8")
    (tmp_path / "structure.toml").write_text(STRUCTURE, encoding="utf-8")
    result = run("budget", tmp_path / "budget.toml", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    rows = list(csv.DictReader((tmp_path / "out" / "harmonics.csv").read_text(encoding="utf-8").splitlines()))
    orders = {float(r["order"]): r for r in rows}
    assert {15.5, 16.0, 16.5, 17.0} <= orders.keys()
    assert float(orders[16.0]["frequency_Hz"]) == pytest.approx(760.0)
    for r in rows:
        assert float(r["floor_Nm"]) >= 0.99e4 * float(r["error_Nm"])
        assert float(r["sigma_Nm"]) >= 0.999 * float(r["error_Nm"])
        assert bool(r["two_way_phase_deg"]) == bool(r["two_way_amplitude_Nm"])
    assert "lines above highest_hz" not in " ".join(result.stdout.split())
    (tmp_path / "budget.toml").write_text(text.replace("rates = ", "highest_hz = 500.0\nrates = "), encoding="utf-8")
    cut = run("budget", tmp_path / "budget.toml", "--out", tmp_path / "out")
    assert "that of the microsteps, order 16, which reaches 760 Hz" in " ".join(cut.stdout.split())


@pytest.mark.slow
def test_the_example_runs_as_it_is(run, tmp_path):
    """Truth: the file as the demo writes it, without a change; every mode stands against every requirement."""
    write_estimate_of_paper(tmp_path, fit_percent=99.0)
    write_example(tmp_path)
    result = run("budget", tmp_path / "budget.toml", "--out", tmp_path / "out", "--workers", "2")
    assert result.exit_code == 0, result.stderr
    data = json.loads((tmp_path / "out" / "budget.json").read_text(encoding="utf-8"))
    assert [(r["requirement"], r["mode"]) for r in data["requirements"]] == [
        (requirement, mode)
        for mode in ("scan", "slew", "run up", "all modes, by duty")
        for requirement in ("stability in an exposure", "pointing")
    ]
    assert (tmp_path / "out" / "budget.html").stat().st_size > 500_000


@pytest.mark.slow
def test_lent_out_it_is_the_same_to_the_last_bit(lent, folder):
    """Truth: the files of the run in threads; a rate has several motions, found from those of its neighbours."""
    sticky = SMALL.replace("[flight]\n", "[flight]\nvalues = { friction.static = 0.03, friction.viscous = 0.002 }\n")
    sticky = sticky.replace("rates = [20.0, 47.5]", "rates = [21.0, 24.0, 27.0]")
    (folder / "budget.toml").write_text(sticky, encoding="utf-8")
    lent("budget", folder / "budget.toml", files=["steady_states.csv", "harmonics.csv", "envelope.csv"], least=6)
