"""A whole job in Python without a file: from arrays to a budget. Truth: the values that made the samples."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib import pyplot
from scipy.signal import StateSpace

import mechid
from mechid.campaign.catalogue_values import CATALOGUE

TRUTH = {"gear.stiffness": 2000.0, "gear.damping": 0.45}
NOISE_NM, RATE_HZ, SECONDS = 0.002, 10_000.0, 0.25
COMMANDS = {
    "full_46": mechid.make_command("full", rate=46.0, start_angle_deg=45.0),
    "micro_46": mechid.make_command("micro", microsteps=16, rate=[[0.0, 40.0], [0.25, 52.0]]),
}
BODY = StateSpace([[0.0, 1.0], [-400.0, -0.4]], [[0.0], [0.1]], [[1.0, 0.0]], [[0.0]])
BUDGET = {
    "mode": [{"name": "slew", "command": {"stepping": "full", "rate": 46.0}}],
    "requirement": [
        {
            "name": "jitter",
            "index": "APE",
            "axis": "x",
            "limit_rad": 1e-4,
            "interpretation": "temporal",
            "confidence": 0.95,
            "evaluation_period_s": 600.0,
        }
    ],
}


@pytest.fixture(scope="module")
def mechanism():
    return mechid.catalogue_mechanism().with_free(tuple(TRUTH))


@pytest.fixture(scope="module")
def measured(mechanism):
    """Return the noisy torque of each command at the truth, (n,) N m."""
    planned = [mechid.make_record(name, command=command) for name, command in COMMANDS.items()]
    campaign = mechid.make_campaign(mechanism.with_values(TRUTH), planned)
    rng = np.random.default_rng(7)
    runs = {name: mechid.simulate(campaign, name, sample_rate_hz=RATE_HZ, duration_s=SECONDS) for name in COMMANDS}
    return {name: run.torque + NOISE_NM * rng.standard_normal(run.time.size) for name, run in runs.items()}


@pytest.fixture(scope="module")
def campaign(mechanism, measured):
    records = [
        mechid.make_record(
            name,
            torque,
            sample_rate_hz=RATE_HZ,
            command=COMMANDS[name],
            use="estimate" if name == "full_46" else "validate",
        )
        for name, torque in measured.items()
    ]
    return mechid.make_campaign(mechanism, records, name="bench")


@pytest.fixture(scope="module")
def fit(campaign):
    return mechid.identify(campaign, workers=1)


def test_a_campaign_in_memory_is_looked_at_and_checked(campaign):
    assert mechid.check(campaign).warnings == ()
    seen = mechid.look(campaign)
    assert [look.record.name for look in seen.looks] == list(COMMANDS)
    assert seen.looks[0].channels[0].rms == pytest.approx(np.std(campaign.records[0].data.channels[0].data), rel=1e-9)


def test_the_truth_is_found_within_its_errors(fit):
    assert fit.grade is mechid.Grade.A
    for name, value in TRUTH.items():
        found = fit.parameters[name]
        assert abs(found.value - value) < 4.0 * found.std_error


def test_what_is_left_of_a_record_held_out_is_its_noise(campaign, fit):
    judged = mechid.validate(campaign, fit)
    assert repr(judged) == "<Validations: full_46, micro_46>"
    assert "micro_46" in str(judged)
    channel = judged["micro_46"].channels["torque"]
    assert channel.residual_rms == pytest.approx(NOISE_NM, rel=0.05)


@pytest.mark.slow
def test_what_the_mechanism_lacks_is_named_of_samples_in_memory(mechanism):
    """Truth: the harmonic of the torque constant that made the records."""
    harmonic = {"order": 3, "amplitude": 0.01, "phase_deg": 40.0}
    tables = {**CATALOGUE, "stepper": {**CATALOGUE["stepper"], "torque_harmonic": [harmonic]}}
    planned = [mechid.make_record(name, command=command) for name, command in COMMANDS.items()]
    bench = mechid.make_campaign(mechid.make_mechanism(tables).with_values(TRUTH), planned)
    rng = np.random.default_rng(11)
    records = []
    for name, command in COMMANDS.items():
        run = mechid.simulate(bench, name, sample_rate_hz=RATE_HZ, duration_s=SECONDS)
        torque = run.torque + NOISE_NM * rng.standard_normal(run.time.size)
        records.append(mechid.make_record(name, torque, sample_rate_hz=RATE_HZ, command=command))
    campaign = mechid.make_campaign(mechanism, records)
    fit = mechid.identify(campaign, workers=1)
    found = mechid.diagnose(campaign, fit, consider=["stepper.torque_harmonic"], workers=1)
    assert [one.name for one in found.missing] == ["stepper.torque_harmonic:3"]
    own = found.missing[0].parameters
    (amplitude,) = (p for name, p in own.items() if name.endswith("amplitude"))
    assert abs(amplitude.value - 0.01) < 4.0 * amplitude.std_error


def test_intervals_by_profile_and_by_draws_hold_the_truth(campaign, fit):
    profile = mechid.profile(campaign, fit, "gear.stiffness", workers=1)["gear.stiffness"]
    low, high = profile.interval
    sigma = fit.parameters["gear.stiffness"].std_error
    assert high - low == pytest.approx(2.0 * 1.96 * sigma, rel=0.2)
    scatter = mechid.bootstrap(campaign, fit, 8, workers=1)
    assert [spread.name for spread in scatter.spreads] == list(TRUTH)
    assert scatter.spreads[0].deviation == pytest.approx(sigma, rel=0.8)  # eight draws tell a deviation to a quarter


def test_a_journal_takes_up_a_run(campaign, fit, tmp_path):
    first = mechid.bootstrap(campaign, fit, 4, workers=1, journal=tmp_path / "draws.jsonl")
    again = mechid.bootstrap(campaign, fit, 4, workers=1, journal=tmp_path / "draws.jsonl", resume=True)
    assert [draw.values for draw in again.draws] == [draw.values for draw in first.draws]
    moved = replace(fit.parameters["gear.damping"], value=0.4)
    other = replace(fit, parameters={**fit.parameters, "gear.damping": moved})
    with pytest.raises(mechid.UsageError, match="cannot be resumed"):
        mechid.bootstrap(campaign, other, 4, workers=1, journal=tmp_path / "draws.jsonl", resume=True)


def test_what_flies_is_the_fit_itself(fit, tmp_path):
    structure = mechid.from_state_space(BODY, ("x",), has_interface=False)
    budget = mechid.budget(BUDGET, fit=fit, structure=structure)
    assert budget.estimate.mechanism.value("gear.stiffness") == fit.parameters["gear.stiffness"].value
    (standing,) = budget.standings[:1]
    torque = budget.modes[0].responses[0]
    omega = 2.0 * np.pi * torque.state.frequency_hz
    held = np.abs(0.1 / (400.0 - omega**2 + 0.4j * omega)) @ np.abs(torque.state.lines)
    assert 0.0 < standing.level.value <= held  # no error is larger than all lines in step
    assert {path.name for path in budget.write(tmp_path / "budget")} >= {"budget.json", "budget.html", "budget.md"}
    axes = budget.plot(ax=pyplot.figure().subplots())
    assert [tick.get_text() for tick in axes.get_yticklabels()] == ["jitter\nslew"]
    (shown,) = budget.to_dict()["requirements"][:1]
    (level,) = next(line.get_xdata() for line in axes.get_lines() if line.get_label() == "level")
    assert level == pytest.approx(shown["decided"]["level_rad"] / shown["limit_rad"])
    pyplot.close("all")


def test_files_for_others_and_the_report_come_from_the_same_fit(campaign, fit, tmp_path):
    done = mechid.export(fit, to="tables", out=tmp_path / "tables", campaign=campaign)
    assert done.written.checked.largest_error < 1e-4
    files = {path.name for path in mechid.report(fit, tmp_path / "fit", truth=TRUTH)}
    assert {"estimate.json", "report.html", "report.json", "mechanism.toml", "figures"} <= files
    again = mechid.load_fit(tmp_path / "fit", campaign)
    assert again.parameters == fit.parameters
    assert "SYNTHETIC" in (tmp_path / "fit" / "mechanism.toml").read_text()
    same = mechid.compare(fit, again, names=("made", "read"))
    assert [one.name for one in same.hypotheses] == ["made", "read"]
    assert same.scores[0].bic == same.scores[1].bic
