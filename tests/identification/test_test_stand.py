"""Test stands that differ from record to record. Truth: values that made the records, run by the slow twin."""

import re
from dataclasses import replace

import numpy as np
import pytest

from csv_files import write_csv
from freed import assert_found, freed
from layouts import changed, mechanism_of, paper_table
from mechid.analysis import validate
from mechid.analysis.information import record_information
from mechid.campaign import load_campaign, mechanism_text
from mechid.campaign.prediction import simulate
from mechid.checks.numbers import check_numbers
from mechid.errors import InputFileError
from mechid.identification.identify import identify, make_problem
from mechid.identification.output_error.declaration import DECLARED
from mechid.identification.readings.alternatives import judge
from mechid.identification.readings.trial import first_moments
from paper import constant
from runs import base, run_twin

NOISE_NM = 2e-3
TICK_S = 4e-4
"""Of the driver's clock: a microstep every 1.36 ms waits for it up to that long."""
STAND = {
    "transducer": {"law": "adaptor", "gain": 1.0, "stiffness": 2.0e4, "adaptor_inertia": 1e-4, "damping": 0.05},
    "charge_amplifier": {"time_constant": 0.15},
    "anti_alias": {"frequency": 16000.0, "order": 4},
}
SHARED = (
    "transducer.adaptor_inertia",
    "transducer.damping",
    "charge_amplifier.time_constant",
    "anti_alias.frequency",
    "stepper.torque_constant",
    "gear.stiffness",
    "gear.damping",
    "housing.frequency",
)
RUNS = {"full_5": (5.0, 1), "full_46": (46.0, 1), "micro_46": (46.0, 16)}
OWN = {
    "full_5": {"transducer.gain": 1.07, "time_offset_s": 4.3e-4},
    "full_46": {"transducer.gain": -0.94, "charge_amplifier.time_constant": 0.22, "time_offset_s": -2.7e-4},
    "micro_46": {"transducer.gain": 1.02, "time_offset_s": 1.1e-4},
}
"""Of each record: its gain, which the cable of one reverses, its delay, and of one the time constant."""


def free(value, off):
    low, high = sorted((0.5 * value, 2.0 * value))
    return f"{{ value = {off * value!r}, min = {low!r}, max = {high!r} }}"


def written(folder, seconds=0.6, own=free):
    """Write a campaign of records that each went through a stand of their own; returns the truth by name."""
    m, rng = mechanism_of(changed(paper_table(), STAND)), np.random.default_rng(19)
    truth = {name: m.value(name) for name in SHARED}
    lines = ['mechanism = "mechanism.toml"']
    for name, (rate, microsteps) in RUNS.items():
        stand = {key: value for key, value in OWN[name].items() if "." in key}
        command = replace(constant(rate, microsteps=microsteps), clock_tick_s=TICK_S)
        delay = OWN[name]["time_offset_s"]
        time_base = base(seconds)
        y = run_twin(m.with_values(stand), command, time_base, offset_s=delay).y[:, 0]
        y = y + rng.normal(0.0, NOISE_NM, y.size) + rng.normal(0.0, 0.01)
        write_csv(folder / f"{name}.csv", "time_s,torque_Nm", time_base.times, y)
        steps = f'stepping = "micro", microsteps = {microsteps}' if microsteps > 1 else 'stepping = "full"'
        entries = ", ".join(f"{key} = {own(value, 1.02)}" for key, value in stand.items())
        lines += [
            "[[record]]",
            f'name = "{name}"',
            f'file = "{name}.csv"',
            "drift = false",
            f"command = {{ {steps}, rate = {rate}, start_angle_deg = 45.0, clock_tick_s = {TICK_S} }}",
            "time_offset_s = { value = 0.0, min = -1e-3, max = 1e-3 }",
            f"test_stand = {{ {entries} }}",
        ]
        truth |= {f"record.{name}.{key}": value for key, value in OWN[name].items()}
    names = ", ".join(f'"{name}"' for name in truth)
    for window in ("window_s = [0.0, 0.03]", "window_s = [0.0, 0.15]", ""):
        lines += ["[[stage]]", window, f"free = [{names}]"]
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n")
    text = mechanism_text(m)
    (folder / "mechanism.toml").write_text(freed(text, {name: truth[name] for name in SHARED}, off=1.01))
    return truth


@pytest.mark.slow
def test_all_effects_of_test_stands_are_found_within_their_errors(tmp_path):
    """High-pass, anti-alias filter, resonance, gain, polarity, delay, offset, clock; shared, and each record's own."""
    truth = written(tmp_path)
    campaign = load_campaign(tmp_path)
    fit = identify(campaign)
    assert_found(fit, truth, sigmas=3.5, largest=0.3)
    pulls = [(fit.parameters[n].value - v) / fit.parameters[n].std_error for n, v in truth.items()]
    assert np.sqrt(np.mean(np.square(pulls))) < 1.0 + 2.5 / np.sqrt(2.0 * len(pulls))
    for name, record in validate(campaign, fit).items():
        assert fit.records[name].residual_rms == pytest.approx(NOISE_NM, rel=0.05)
        assert record.channels["torque"].residual_rms == pytest.approx(NOISE_NM, rel=0.05)
    information = record_information(campaign, fit)
    at = information.parameters.index("record.full_46.charge_amplifier.time_constant")
    assert information.share[at, information.records.index("full_46")] == pytest.approx(1.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("stands")
    written(made, seconds=0.05)
    return made


@pytest.mark.slow
def test_derivatives_to_a_record_s_own_stand_are_those_of_its_own_samples(folder):
    """Truth: differences of the prediction; the samples of other records do not move."""
    problem = make_problem(load_campaign(folder), 1)
    q, whole = problem.start, problem.whole_windows()
    names = problem.coordinates.names
    own = [j for j, name in enumerate(names) if name.startswith("record.") and "time_offset" not in name]
    assert len(own) == 4
    for target in problem.targets:
        J = np.zeros((target.samples, problem.size))
        for block in problem.model.run(target, q, target.samples, jacobian=True).blocks():
            J[block.start : block.stop] = problem.coordinates.block_slopes(target, 0, block, block.stop - block.start)
        assert whole[target.name] == (0, target.samples)
        for j in (*own, names.index("charge_amplifier.time_constant")):
            step = np.zeros(problem.size)
            step[j] = 1e-5 * max(abs(q[j]), 1e-3)
            ahead, behind = (problem.model.predict(target, q + s * step, target.samples)[0] for s in (1, -1))
            slope = (ahead - behind) / (2.0 * step[j])
            size = np.linalg.norm(slope)
            moves = names[j].startswith(f"record.{target.name}.") or (
                not names[j].startswith("record.") and target.name != "full_46"
            )
            assert (size > 0.0) == moves
            assert np.linalg.norm(J[:, j] - slope) <= 1e-5 * size


def test_a_record_with_a_stand_of_its_own_is_judged_by_the_others(folder):
    """Truth: its cost as declared is that of the problem at the same point, over the same first moments."""
    problem = make_problem(load_campaign(folder), 1)
    target = problem.targets[1]
    start = target.truncate(first_moments(target))
    declared = judge(problem, problem.start, target, start.samples)[0]
    alone = replace(problem, targets=(target,))
    assert declared.reading == DECLARED
    assert declared.cost == pytest.approx(alone.norm(start, alone.start, (0, start.samples)) ** 2, rel=1e-12)


def test_known_values_of_a_record_hold_for_it_alone(tmp_path):
    """Truth: the twin with these values."""
    written(tmp_path, seconds=0.05, own=lambda value, _: repr(value))
    text = (tmp_path / "campaign.toml").read_text()
    (tmp_path / "campaign.toml").write_text(text[: text.index("[[stage]]")])
    (tmp_path / "mechanism.toml").write_text(mechanism_text(mechanism_of(changed(paper_table(), STAND))))
    campaign = load_campaign(tmp_path, read_records=False)
    m = campaign.mechanism.with_values({"transducer.gain": -0.94, "charge_amplifier.time_constant": 0.22})
    torque = simulate(campaign, "full_46", sample_rate_hz=1e4, duration_s=0.05).torque
    twin = run_twin(m, replace(constant(46.0), clock_tick_s=TICK_S), base(0.05)).y[:, 0]
    (line,) = [line for line in check_numbers(campaign)["records"][1]["lines"] if "of its own" in line]
    assert line == "of its own: transducer.gain = -0.94, charge_amplifier.time_constant = 0.22"
    assert np.linalg.norm(torque - twin) <= 1e-5 * np.linalg.norm(twin)


@pytest.mark.parametrize(
    ("entry", "says"),
    [
        ("{ transducer.gian = 2.0 }", 'record[0].test_stand.transducer.gian: unknown key; did you mean "gain"?'),
        ("{ gear.stiffness = 2.0 }", "record[0].test_stand.gear: unknown key"),
        ("{ drive.offset = 2.0 }", "record[0].test_stand.drive: the mechanism has none; write [drive] in its file"),
        ("{ transducer = 2.0 }", "record[0].test_stand.transducer: found 2.0; write a table"),
        ("3", "record[0].test_stand: found 3; write a table"),
        (
            "{ charge_amplifier.time_constant = 0.0 }",
            "record[0].test_stand.charge_amplifier.time_constant: found 0; the equations divide by it",
        ),
        ("{ anti_alias.order = 3 }", "record[0].test_stand.anti_alias.order: unknown key"),
    ],
)
def test_a_wrong_test_stand_says_where_and_what(folder, tmp_path, entry, says):
    text = (folder / "campaign.toml").read_text()
    (tmp_path / "campaign.toml").write_text(re.sub(r"test_stand = .*", f"test_stand = {entry}", text, count=1))
    (tmp_path / "mechanism.toml").write_text((folder / "mechanism.toml").read_text())
    with pytest.raises(InputFileError, match=re.escape(f"campaign.toml: {says}")):
        load_campaign(tmp_path, read_records=False, need_files=False)
