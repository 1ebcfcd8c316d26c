"""Whole lab benches: equal seeds give equal files, and what the files declare is how the records were made."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lab_benches
from lab.benches import SCATTER_S, TRIGGER_S, make_bench, near_truth, runs_of, simulated
from lab.measurement import BITS, COLUMNS, HUM, MAINS_HZ
from lab.mechanisms import drawn_mechanism, modes_of, ratio_of
from lab.plant import values_of
from mechid.campaign import load_campaign
from mechid.command import Command, Timing
from mechid.identification.identify import make_problem
from mechid.identification.output_error.misfit import misfit_series
from mechid.identification.search.first_moments import first_window
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from recovery.campaigns import NOISE_NM, RATE_HZ
from runs import rms

SEED, SWEEP_S = 0, 1.0


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return a bench whose sweep is cut short, its campaign, and its problem at the truth."""
    bench = make_bench(SEED, tmp_path_factory.mktemp("lab"), sweep_s=SWEEP_S)
    campaign = load_campaign(bench.folder)
    problem = replace(make_problem(campaign, 1), substeps=2)
    return bench, campaign, problem, problem.coordinates.point({**bench.truth, **bench.own})


@pytest.mark.parametrize("name", ["full_res", "half_res", "micro_res", "sweep"])
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_the_simulator_is_the_kernel(seed, name):
    """Truth: the kernel, which shares no code with it; one mode of the load, and two."""
    mechanism, truth = drawn_mechanism(seed)
    mechanism = mechanism.with_values(truth)
    mechanism = replace(mechanism, plant=mechanism.plant.with_outputs(("torque", "rotor_rate")))
    run = replace(runs_of(mechanism)[name], seconds=1.0)
    delay_s, clock_ppm = 0.51, 40.0
    own = simulated(values_of(mechanism.value, modes_of(mechanism)), run, delay_s, clock_ppm)
    base = TimeBase(RATE_HZ, own[0].size)
    simulator = Simulator(mechanism.plant, Command.from_table(dict(run.command), "command", Path()), base)
    found = simulate_run(simulator.run(mechanism.kernel_values(), timing=Timing(delay_s, clock_ppm), substeps=8))
    for y, quantity in zip(own, ("torque", "rotor_rate"), strict=True):
        assert rms(y - found.values[quantity]) < 1e-5 * rms(y), quantity


def left(problem, target, q, k):
    """Return what the model leaves of a channel, samples that count, without offset, drift and lines."""
    channel, r = target.channels[k], np.array(misfit_series(problem.model, target, q, (0, target.samples))[k][:])
    r -= channel.line(r, channel.rejected).at(0, r.size)
    return np.delete(r, channel.rejected)


@pytest.mark.slow
def test_the_truth_leaves_nothing_but_noise(made):
    """Truth: the noise laid over each channel; triggers, clock, hum, filter and lever arm are as declared."""
    bench, campaign, problem, q = made
    noise_Nm = NOISE_NM * ratio_of(campaign.mechanism)
    for target in problem.targets:
        assert target.quantities == ("torque", "rotor_rate")
        rms = [np.sqrt(np.mean(left(problem, target, q, k) ** 2)) for k in (0, 1)]
        near = 0.1 if target.name == bench.clipped else 0.03  # beside its range a clipped sample is cut, noise and all
        assert rms[0] == pytest.approx(noise_Nm, rel=near), target.name
        assert rms[1] == pytest.approx(0.05, rel=0.03), target.name


@pytest.mark.slow
def test_a_trigger_of_the_file_is_not_the_truth(made):
    """Truth: 20 ms of scatter, in which the torque turns by half a period of the resonance."""
    bench, _, problem, q = made
    target = next(t for t in problem.targets if abs(bench.own[f"record.{t.name}.time_offset_s"] - TRIGGER_S) > 0.01)
    moved = q.copy()
    moved[problem.coordinates.names.index(target.time_offset.name)] = TRIGGER_S
    assert np.std(left(problem, target, moved, 0)) > 20.0 * np.std(left(problem, target, q, 0))


def test_first_windows_begin_at_the_motion(made):
    bench, _, problem, _ = made
    for target in problem.targets:
        begins_s = first_window(target)[0] / target.base.sample_rate_hz
        assert -0.01 < begins_s - bench.own[f"record.{target.name}.time_offset_s"] < 0.25, target.name


def test_equal_seeds_give_equal_files(made, tmp_path):
    again = make_bench(SEED, tmp_path, sweep_s=SWEEP_S).folder
    files = sorted(path.name for path in again.iterdir())
    assert files == sorted(path.name for path in made[0].folder.iterdir())
    for name in files:
        assert (again / name).read_bytes() == (made[0].folder / name).read_bytes(), name


def test_the_files_say_what_was_drawn(made):
    bench, campaign, _, _ = made
    told = json.loads((bench.folder / "truth.json").read_text())
    assert told["synthetic"]
    assert campaign.synthetic
    assert {p.name for p in campaign.free} == {*told["parameters"], *told["own"]}
    table = tomllib.loads((bench.folder / "campaign.toml").read_text())
    assert table["identify"] == {"mains": 50}
    (clipped,) = (record for record in table["record"] if "conditioning" in record)
    assert clipped["name"] == bench.clipped
    low, high = clipped["conditioning"]["limits"]["torque"]
    rows = np.loadtxt(bench.folder / f"{bench.clipped}.csv", delimiter=",", skiprows=1)
    torque = rows[:, 1 + COLUMNS.index("Mz")]
    assert (torque.min(), torque.max()) == (low, high)
    assert np.sum((torque == low) | (torque == high)) > 8
    steps = torque[np.abs(torque) < high] / ((high - low) / 2**BITS)
    np.testing.assert_allclose(steps, np.round(steps), atol=2e-3)  # the file has eight digits


def test_hum_is_twice_the_noise(made):
    """Truth: its amplitude at its frequency in the rest before the first command."""
    bench, campaign, _, _ = made
    rows = np.loadtxt(bench.folder / "full_slow.csv", delimiter=",", skiprows=1)[:4000]
    torque = rows[:, 1 + COLUMNS.index("Mz")]
    line = np.exp(-2j * np.pi * MAINS_HZ * rows[:, 0])
    amplitude = 2.0 * abs(np.mean((torque - torque.mean()) * line))
    assert amplitude == pytest.approx(HUM * NOISE_NM * ratio_of(campaign.mechanism), rel=0.1)


@pytest.mark.parametrize("seed", range(12))
def test_truths_lie_within_what_is_declared(seed):
    mechanism, truth = drawn_mechanism(seed)
    assert 18 <= len(truth) <= 25
    assert {p.name for p in mechanism.free} == set(truth)
    for name, value in truth.items():
        p = mechanism.parameters[name]
        assert p.is_periodic or p.min <= value <= p.max, name
    assert 50 <= mechanism.value("gear.ratio") <= 200


def test_odd_seeds_leave_the_clock_to_mechid(tmp_path):
    bench = make_bench(1, tmp_path, sweep_s=SWEEP_S)
    table = tomllib.loads((bench.folder / "campaign.toml").read_text())
    assert "clock_ppm" not in table
    assert table["clock_reference"] == "recorder"
    assert "campaign.clock_ppm" in bench.own


def test_near_starts_are_within_a_share_of_the_truth(made):
    bench, campaign, _, _ = made
    start = near_truth(bench, campaign, 0.1)
    assert set(start) == {p.name for p in campaign.free}
    for name, value in bench.truth.items():
        if not name.endswith("phase_deg"):
            assert abs(start[name] / value - 1.0) <= 0.1 + 1e-9, name
    assert all(abs(start[n] - v) <= 0.1 * SCATTER_S for n, v in bench.own.items() if n.endswith("time_offset_s"))


def test_what_is_made_only_is_not_fitted(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["lab_benches.py", "--seeds", "0:1", "--make-only", "--out", str(tmp_path)])
    monkeypatch.setattr(lab_benches, "make_bench", lambda seed, folder: make_bench(seed, folder, sweep_s=SWEEP_S))
    lab_benches.main()
    assert (tmp_path / "lab_0" / "truth.json").exists()
    assert not (tmp_path / lab_benches.LINES).exists()
    assert "lab_0" in capsys.readouterr().out


def test_a_summary_counts_what_is_followed_with_a_good_grade():
    """Truth: counted by hand: of three fits one is followed to its ends with grade A, one has grade C, one stops."""
    line = {
        "start": "catalogue",
        "cpu_s": 1.0,
        "wall_s": 1.0,
        "named": [],
        "errors": {"a": 1.0, "b": -4.0, "c": None},
    }
    one = line | {"seed": 0, "grade": "A", "followed": {"x": 100.0, "y": 100.0}, "records_followed": 2}
    two = line | {"seed": 1, "grade": "C", "followed": {"x": 100.0, "y": 100.0}, "records_followed": 2}
    three = line | {"seed": 2, "grade": "B", "followed": {"x": 100.0, "y": 40.0}, "records_followed": 1}
    text = lab_benches.summary([two, one, three])
    assert "1 of 3 followed to their ends with grade A or B" in text
    assert "3 of 9 parameters within 3 stated sigma" in text
    assert text.splitlines()[0].startswith("lab 0 from catalogue: grade A, 2 of 2 records")
    assert "worst 4 (b)" in text
