"""Windows in which starts are judged. Truth: the instant at which the records' commands begin."""

from dataclasses import replace

import numpy as np
import pytest

from complete_benches import Bench, catalogue, noisy
from complete_fits import COULOMB, GEARED, table
from csv_files import write_csv
from layouts import mechanism_of
from mechid.analysis import validate
from mechid.campaign import catalogue_mechanism, load_campaign, mechanism_text
from mechid.command import Command, InputChannel, MeasuredCommand, RateProfile
from mechid.identification.identify import identify, identify_from, make_problem
from mechid.identification.readings.timing import find_long_rest
from mechid.identification.result.grade import FitOutcome
from mechid.identification.search.box import sample_box
from mechid.identification.search.first_moments import first_window, robust_cost
from mechid.identification.search.multistart import capped_costs
from mechid.identification.search.settings import SEARCH
from mechid.identification.uncertainty.visibility import unseen_parameters
from mechid.reports.numbers import report_data
from mechid.simulation.simulator import Simulator
from mechid.simulation.start import Start
from paper import constant
from runs import base, run_kernel
from synthetic import COMMANDS, RATE_HZ, campaign, measured, record, truth

FREE = {"value": 0.5, "min": 0.0, "max": 1.0}
FIRST_STEP_S = {name: 1.0 / COMMANDS[name].rate.rates[0] / COMMANDS[name].microsteps for name in COMMANDS}


def rested(name, rest_s, *, seconds=0.5, offset=None, hum=0.0):
    """Return a record that begins before its command, whose time offset is declared as `offset`."""
    rng = np.random.default_rng((5, list(COMMANDS).index(name)))
    y = measured(truth(), COMMANDS[name], rng, seconds=rest_s + seconds, time_offset_s=rest_s)
    y += hum * np.sin(2.0 * np.pi * 50.0 * np.arange(y.size) / RATE_HZ)
    made = record(name, y, COMMANDS[name], time_offset=offset)
    known = replace(made.parameters[0], value=rest_s)
    return made if offset else replace(made, parameters=(known,))


def problem(*records):
    return make_problem(campaign(catalogue_mechanism(), *records), 1)


def window_s(made):
    """Return the first window of a record, s."""
    first, stop = first_window(problem(made).targets[0])
    return first / RATE_HZ, stop / RATE_HZ


@pytest.mark.parametrize("name", ["full_46", "micro_46"])
@pytest.mark.parametrize("rest_s", [0.1, 0.5, 1.5])
def test_the_window_begins_where_the_motion_does(name, rest_s):
    """Truth: the torque changes at the first step commanded, not before."""
    first, stop = window_s(rested(name, rest_s))
    assert rest_s - 0.006 < first < rest_s + FIRST_STEP_S[name] + 0.02
    assert stop - first == pytest.approx(0.06)


@pytest.mark.parametrize("value", [0.1, 0.5, 0.9])
def test_the_motion_counts_and_not_a_time_offset_that_is_to_be_found(value):
    """Truth: the command begins at 0.5 s, wherever its time offset starts."""
    first, _ = window_s(rested("full_46", 0.5, offset=FREE | {"value": value}))
    assert 0.49 < first < 0.54


def test_hum_at_rest_is_no_motion():
    """Truth: 50 Hz of 15 standard deviations of the noise, and full steps from 0.5 s on."""
    first, _ = window_s(rested("full_46", 0.5, hum=0.03))
    assert 0.49 < first < 0.54


@pytest.mark.parametrize("name", list(COMMANDS))
def test_records_that_begin_with_their_command_are_judged_from_their_first_sample(name):
    assert window_s(rested(name, 0.0)) == (0.0, 0.06)


def test_a_short_rest_leaves_the_window_where_it_is():
    """Truth: 20 ms of rest before microsteps leave 40 ms of motion in the window."""
    assert window_s(rested("micro_46", 0.02)) == (0.0, 0.06)


def test_starts_differ_in_cost_behind_half_a_second_of_rest():
    """Truth: the same records without their rest, whose costs order the starts alike."""
    with_rest, without = (problem(*(rested(name, rest) for name in ("full_46", "micro_46"))) for rest in (0.5, 0.0))
    points = list(sample_box(with_rest.space, 32, 0))
    costs = [capped_costs(one, points, targets=one.targets) for one in (with_rest, without)]
    assert np.ptp(costs[0]) > 0.5 * np.ptp(costs[1])
    assert np.corrcoef(np.log(costs))[0, 1] > 0.5


def test_starts_are_simulated_side_by_side_up_to_a_late_window():
    """Truth: each start simulated by itself. The command begins with the record, and its first step after 0.5 s."""
    command = constant(2.0)
    y = np.zeros(round(0.7 * RATE_HZ))
    y[5000:] = np.sin(np.arange(2000))
    slow = problem(record("slow", y, command))
    points = list(sample_box(slow.space, 8, 0))
    assert first_window(slow.targets[0])[0] > 4900
    together = capped_costs(slow, points, targets=slow.targets)
    alone = [capped_costs(slow, [point], targets=slow.targets)[0] for point in points]
    np.testing.assert_allclose(together, alone, rtol=1e-9)


def test_a_rest_too_long_for_the_window_is_said_with_what_to_write():
    """Truth: 3 s of rest; what is written leaves out most of it and keeps the first step."""
    made = rested("full_46", 3.0)
    line = find_long_rest(problem(made).targets[0]).line()
    assert "record full_46" in line
    assert "window_s = [2.9" in line
    assert find_long_rest(problem(rested("full_46", 0.5)).targets[0]) is None


def test_parameters_are_seen_behind_a_rest_longer_than_a_second():
    """Truth: the same record without its rest."""
    with_rest, without = (campaign(catalogue_mechanism(), rested("full_46", rest)) for rest in (1.5, 0.0))
    assert unseen_parameters(with_rest) == unseen_parameters(without)


@pytest.mark.slow
def test_records_that_begin_half_a_second_early_are_fitted_from_the_catalogue():
    """Truth: the mechanism that made the records."""
    made = campaign(catalogue_mechanism(), *(rested(name, 0.5) for name in COMMANDS))
    fit = identify(made, workers=1)
    assert fit.outcome is FitOutcome.CONVERGED
    for name in ("stepper.torque_constant", "gear.stiffness", "stepper.coil_resistance"):
        p = fit.parameters[name]
        assert abs(p.value - truth().value(name)) < 5.0 * p.std_error, name


@pytest.mark.parametrize("size", [1e-12, 1e-9, 1e-4])
def test_tiny_residuals_are_squared(size):
    """A mechanism at rest under the start's friction leaves next to nothing: that is no cost of exactly zero."""
    r = np.full(100, size)
    assert robust_cost(r) == pytest.approx(100 * size**2, rel=1e-8)


def test_large_residuals_count_by_their_size():
    r = np.array([1e9])
    assert robust_cost(r) == pytest.approx(2.0 * SEARCH.robust_sigmas * 1e9, rel=1e-6)


FULL, MICRO = 'stepping = "full", rate = {}, start_angle_deg = 45.0', 'stepping = "micro", microsteps = 16, rate = {}'
CUTS = {
    "full_46": (FULL.format(46.0), 2.03, 0.57),
    "micro_46": (MICRO.format(46.0), 1.5, 0.5),
    "full_5": (FULL.format(5.0), 1.013, 0.6),
}
"""Command, first instant and length of each record, s."""
RECORD = 'mechanism = "mechanism.toml"\n[[record]]\nname = "run"\nfile = "run.csv"\n'


def cut(folder, free, names=tuple(CUTS), shorter=1.0, seed=5):
    """Write a campaign of records that are parts of longer ones, and read it; returns the truth too."""
    bench, rng = Bench(seed=seed, table=table(), free=free), np.random.default_rng(seed)
    lines = ['mechanism = "mechanism.toml"']
    for name in names:
        text, first_s, length_s = CUTS[name]
        rate = float(text.partition("rate = ")[2].partition(",")[0])
        command = Command(
            stepping="micro" if "micro" in text else "full",
            microsteps=16 if "micro" in text else 1,
            rate=RateProfile.constant(rate),
            start_angle_deg=45.0 if "45" in text else 0.0,
        )
        time_base = base(shorter * length_s, start_s=first_s)
        run = run_kernel(bench.mechanism, command, time_base, substeps=8)
        rows = np.stack([time_base.times, noisy(run.torque, "torque", rng)], axis=1)
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header="time_s,torque_Nm", comments="", fmt="%.12g")
        lines += [
            "[[record]]",
            f'name = "{name}"',
            f'file = "{name}.csv"',
            f'command = {{ {text}, start = "estimated" }}',
        ]
    (folder / "mechanism.toml").write_text(catalogue(bench))
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n")
    return load_campaign(folder), bench.truth


def test_a_held_out_record_gets_its_start_from_its_first_part(tmp_path):
    """Truth: a stretch of 0.57 s that begins in motion; from the start that the command gives it is missed."""
    of, truth = cut(tmp_path, ("gear.stiffness",), ("micro_46", "full_46"))
    held = replace(of.record("full_46"), use="validate")
    of = replace(of, records=(of.record("micro_46"), held))
    fit = identify(of, near={name: value for name, value in truth.items() if name == "gear.stiffness"}, workers=1)
    found = fit.records["full_46"].nuisance
    assert {name.removeprefix("record.full_46.start.") for name in found.parameters} >= {"angle", "rate", "current_a"}
    channel = validate(of, fit)["full_46"].channels["torque"]
    assert channel.fit_percent > 95.0
    assert channel.samples == held.data.samples - found.samples


def assert_within(fit, truth, sigmas=3.5):
    for name, value in truth.items():
        p = fit.parameters[name]
        assert p.std_error is not None, (name, p.status, p.reason)
        assert abs(p.value - value) < sigmas * p.std_error, name
        assert p.std_error < 0.03 * abs(value), name


@pytest.mark.slow
def test_records_cut_out_of_longer_ones_are_identified_from_the_catalogue(tmp_path):
    campaign, truth = cut(tmp_path, COULOMB)
    fit = identify(campaign, workers=1)
    assert fit.grade == "A"
    assert_within(fit, truth)
    again = fit.optimum
    for name, value in again.values(again.q).items():
        assert value == pytest.approx(fit.parameters[name].value, abs=0.05 * (fit.parameters[name].std_error or 1.0))


@pytest.fixture(scope="module")
def one_cut(tmp_path_factory):
    """Return a short part of one record and a fit of it, from values some tenth off."""
    campaign, truth = cut(tmp_path_factory.mktemp("cut"), GEARED[2:], ("full_46",), shorter=0.5)
    start = {name: 1.1 * value for name, value in truth.items()}
    return campaign, truth, identify_from(campaign, start, workers=1)


def test_a_part_of_a_record_is_identified_without_what_was_before(one_cut):
    _, truth, fit = one_cut
    assert fit.grade in {"A", "B"}
    assert_within(fit, truth)
    states = {name: p for name, p in fit.parameters.items() if ".start." in name}
    assert len(states) == 8
    assert any("the start state is estimated too, 8 numbers" in note for note in fit.notes)


def test_what_is_shown_of_it(one_cut):
    """Truth: the fit's own residual; the table of parameters leaves the start to estimate.json."""
    campaign, _, fit = one_cut
    found = validate(campaign, fit)
    data = report_data(fit, validation=found)
    assert not any(".start." in row["name"] for row in data["parameters"])
    assert not any(".start." in line for line in fit.warnings)
    record = fit.records["full_46"]
    assert record.fit_percent > 98.0
    assert record.residual_rms == pytest.approx(2e-3, rel=0.05)
    (shown,) = data["records"]
    assert shown["residual_rms"] == pytest.approx(record.residual_rms, rel=1e-6)


@pytest.mark.slow
def test_a_wrong_start_does_not_spoil_what_comes_after_it(tmp_path):
    """Truth: what made the record; its currents and its gear began otherwise than the model says."""
    bench, rng = Bench(seed=7, table=table(), free=GEARED[2:]), np.random.default_rng(7)
    m, time_base = bench.mechanism, base(0.3)
    command = Command(stepping="full", microsteps=1, rate=RateProfile.constant(46.0), start_angle_deg=45.0)
    off = {"start.current_a": 0.15, "start.current_b": -0.1, "start.twist": 3e-4}
    made = Simulator(m.plant, command, time_base, capacity=32, start=Start(off))
    run = made.run(m.kernel_values(), substeps=8, directions=np.zeros((m.kernel_values().size, 0)))
    y = np.concatenate([b.y[:, 0].copy() for b in run.blocks()])
    write_csv(tmp_path / "run.csv", "time_s,torque_Nm", time_base.times, noisy(y, "torque", rng))
    (tmp_path / "mechanism.toml").write_text(catalogue(bench))

    def campaign(start):
        (tmp_path / "campaign.toml").write_text(f'{RECORD}command = {{ {CUTS["full_46"][0]}, start = "{start}" }}\n')
        return load_campaign(tmp_path)

    spoilt = identify_from(campaign("commanded"), {n: 1.05 * v for n, v in bench.truth.items()}, workers=1)
    assert (spoilt.grade, spoilt.records["run"].residual_rms > 0.02) == ("C", True)
    fit = identify(campaign("estimated"), workers=1)
    assert fit.grade == "A"
    assert fit.records["run"].residual_rms == pytest.approx(2e-3, rel=0.05)
    assert_within(fit, bench.truth)
    for key, value in off.items():
        p = fit.parameters[f"record.run.{key}"]
        assert abs(p.value - value) < 4.0 * p.std_error


AXIS = {
    "assembly": "direct_torque_drive",
    "load": {"inertia": 2e-3},
    "drive": {},
    "friction": {"coulomb": 0.02, "viscous": 0.01},
}


@pytest.mark.parametrize("way", ["estimated", pytest.param("burn_in", marks=pytest.mark.slow)])
def test_a_driven_axis_that_begins_in_motion(tmp_path, way):
    """Truth: what made the record: its file begins in the middle of a swing; friction forgets the start in 0.2 s.

    Its rate is estimated, or the first second does not count. Its angle is measured but for an offset.
    """
    rng, whole = np.random.default_rng(3), base(6.0, rate_hz=1000.0)
    m = mechanism_of(AXIS)
    t = whole.times
    u = 0.06 * np.sin(2 * np.pi * 1.3 * t) + 0.05 * np.sin(2 * np.pi * 3.1 * t + 1.0)
    command = MeasuredCommand().driven_by((InputChannel(quantity="torque", samples=u),), 1000.0, 0.0)
    plant = m.plant.with_outputs(("output_rate",))
    p = m.kernel_values()
    made = Simulator(plant, command, whole, capacity=0).run(p, substeps=8, directions=np.zeros((p.size, 0)))
    y = np.concatenate([b.y[:, 0].copy() for b in made.blocks()]) + rng.normal(0.0, 2e-3, whole.samples)
    kept = t >= 2.2
    write_csv(tmp_path / "run.csv", "time_s,rate,torque", t[kept], y[kept], u[kept], fmt="%.12g")
    assert abs(y[kept][0]) > 0.1
    text = mechanism_text(m).replace("viscous = 0.01", "viscous = { value = 0.013, min = 0.001, max = 0.1 }")
    text = text.replace("inertia = 0.002", "inertia = { value = 0.0025, min = 0.0005, max = 0.01 }")
    (tmp_path / "mechanism.toml").write_text(text)
    own = {
        "estimated": 'command.start = "estimated"\nstart_state = { rate = { value = 0.0, min = -9.0, max = 9.0 } }',
        "burn_in": "burn_in_s = 1.0",
    }
    channels = """channels = [{ quantity = "output_rate", column = 1, unit = "rad/s" },
                  { quantity = "torque", column = 2, unit = "N m", role = "input" }]"""
    (tmp_path / "campaign.toml").write_text(f"{RECORD}{channels}\n{own[way]}\n")
    fit = identify(load_campaign(tmp_path), workers=1)
    assert_within(fit, {"friction.viscous": 0.01, "load.inertia": 2e-3})
    assert fit.records["run"].residual_rms == pytest.approx(2e-3, rel=0.05)
    assert fit.records["run"].rejected == (1000 if way == "burn_in" else 0)
