"""Fits with the library's blocks. Truth: values that made the records, run by the slow twin, noise added."""

import re
from dataclasses import replace

import numpy as np
import pytest

from csv_files import write_csv
from freed import assert_found, freed
from layouts import BRUSHED_DC, changed, mechanism_of, paper_table
from mechid.campaign import load_campaign, mechanism_text
from mechid.campaign.prediction import simulate
from mechid.command import InputChannel, MeasuredCommand
from mechid.identification.identify import identify
from paper import constant
from runs import base, run_twin


@pytest.mark.slow
def test_a_direct_drive_is_found_from_force_and_position(tmp_path):
    truth = {"load.mass": 95.0, "friction.coulomb": 20.0, "friction.viscous": 200.0, "drive.offset": -3.0}
    m = mechanism_of(
        {
            "assembly": "direct_force_drive",
            "load": {"mass": 95.0},
            "drive": {"offset": -3.0},
            "friction": {"static": 25.0, "coulomb": 20.0, "viscous": 200.0},
        }
    )
    time_base, rng = base(4.0, rate_hz=1e3), np.random.default_rng(11)
    t = time_base.times
    force = 3.0 + 60.0 * np.sin(2 * np.pi * 0.7 * t) + 50.0 * np.sin(2 * np.pi * 2.3 * t + 1.0)
    command = MeasuredCommand().driven_by((InputChannel(quantity="force", samples=force),), 1e3, 0.0)
    x = run_twin(m, command, time_base).y[:, 0] + rng.normal(0.0, 2e-5, t.size)
    write_csv(tmp_path / "run.csv", "time_s,F_N,x_m", t, force, x)
    (tmp_path / "mechanism.toml").write_text(freed(mechanism_text(m), truth))
    (tmp_path / "campaign.toml").write_text(
        'mechanism = "mechanism.toml"\n[[record]]\nname = "run"\nfile = "run.csv"\nchannels = [\n'
        '  { quantity = "position", column = "x" },\n  { quantity = "force", column = "F", role = "input" },\n]\n'
        f'[[stage]]\nrecords = ["run"]\nfree = [{", ".join(f"""{chr(34)}{name}{chr(34)}""" for name in truth)}]\n'
    )
    fit = identify(load_campaign(tmp_path))
    assert_found(fit, truth)
    assert fit.records["run"].residual_rms == pytest.approx(2e-5, rel=0.05)


@pytest.mark.slow
def test_a_test_stand_is_found_with_the_mechanism(tmp_path):
    """Transducer resonance by its adaptor, gain, charge amplifier and anti-alias filter, shared by two records."""
    stand = {
        "transducer": {"law": "adaptor", "gain": -1.1, "stiffness": 2.0e4, "adaptor_inertia": 1e-4, "damping": 0.05},
        "charge_amplifier": {"time_constant": 0.15},
        "anti_alias": {"frequency": 16000.0, "order": 4},
    }
    m = mechanism_of(changed(paper_table(), stand))
    truth = {
        name: m.value(name)
        for name in (
            "transducer.gain",
            "transducer.adaptor_inertia",
            "transducer.damping",
            "charge_amplifier.time_constant",
            "anti_alias.frequency",
            "stepper.torque_constant",
            "gear.stiffness",
            "gear.damping",
            "housing.frequency",
        )
    }
    rng, time_base = np.random.default_rng(12), base(0.6)
    records = {"full_5": (5.0, 1), "full_46": (46.0, 1)}
    lines = ['mechanism = "mechanism.toml"']
    for name, (rate, microsteps) in records.items():
        y = run_twin(m, constant(rate, microsteps=microsteps), time_base).y[:, 0]
        y = y + rng.normal(0.0, 2e-3, y.size) + 0.01
        write_csv(tmp_path / f"{name}.csv", "time_s,torque_Nm", time_base.times, y)
        lines += [
            "[[record]]",
            f'name = "{name}"',
            f'file = "{name}.csv"',
            "drift = false",
            f'command = {{ stepping = "full", rate = {rate}, start_angle_deg = 45.0 }}',
        ]
    names = ", ".join(f'"{name}"' for name in truth)
    for window in ("window_s = [0.0, 0.03]", "window_s = [0.0, 0.15]", ""):
        lines += ["[[stage]]", window, f"free = [{names}]"]
    (tmp_path / "campaign.toml").write_text("\n".join(lines) + "\n")
    (tmp_path / "mechanism.toml").write_text(freed(mechanism_text(m), truth, off=1.01))
    fit = identify(load_campaign(tmp_path))
    assert_found(fit, truth, largest=0.2)
    for record in fit.records.values():
        assert record.residual_rms == pytest.approx(2e-3, rel=0.05)


WEIGHT_AND_CABLES = (
    "load.unbalance.amplitude",
    "load.unbalance.phase_deg",
    "load.cable.stiffness",
    "load.cable.hysteresis",
    "load.cable.hysteresis_angle",
)


@pytest.mark.slow
def test_weight_and_cables_are_found_from_torque_and_angle(tmp_path):
    m = mechanism_of(
        {
            "assembly": "two_mass_drive",
            "motor": {"inertia": 1e-4},
            "drive": {},
            "friction": {"coulomb": 0.0, "viscous": 2e-2},
            "gear": {"ratio": 5, "stiffness": 400.0, "damping": 0.5},
            "load": {
                "inertia": 0.02,
                "unbalance": {"amplitude": 0.3, "phase_deg": 40.0},
                "cable": {
                    "law": "dahl",
                    "stiffness": 0.25,
                    "rest_angle": 0.3,
                    "hysteresis": 0.05,
                    "hysteresis_angle": 0.05,
                },
            },
        }
    )
    truth = {name: m.value(name) for name in (*WEIGHT_AND_CABLES, "load.cable.rest_angle", "friction.viscous")}
    m = replace(m, plant=m.plant.with_outputs(("output_angle",)))
    time_base, rng = base(2.5, rate_hz=500.0), np.random.default_rng(7)
    t = time_base.times
    torque = 0.02 + 0.25 * np.sin(2 * np.pi * 0.4 * t) + 0.12 * np.sin(2 * np.pi * 1.3 * t + 1.0)
    command = MeasuredCommand().driven_by((InputChannel(quantity="torque", samples=torque),), 500.0, 0.0)
    angle = run_twin(m, command, time_base).y[:, 0] + rng.normal(0.0, 2e-4, t.size)
    write_csv(tmp_path / "run.csv", "time_s,T,a", t, torque, angle)
    (tmp_path / "mechanism.toml").write_text(freed(mechanism_text(m), truth))
    (tmp_path / "campaign.toml").write_text(
        'mechanism = "mechanism.toml"\n[[record]]\nname = "run"\nfile = "run.csv"\nchannels = [\n'
        '  { quantity = "output_angle", column = "a", unit = "rad", offset = false, drift = false },\n'
        '  { quantity = "torque", column = "T", unit = "N*m", role = "input" },\n]\n'
        f'[[stage]]\nrecords = ["run"]\nfree = [{", ".join(f"""{chr(34)}{name}{chr(34)}""" for name in truth)}]\n'
    )
    fit = identify(load_campaign(tmp_path))
    assert_found(fit, truth)
    assert fit.records["run"].residual_rms == pytest.approx(2e-4, rel=0.07)


@pytest.mark.slow
def test_weight_and_cables_are_found_from_torque_alone(tmp_path):
    """A stepper there and back over 79 deg of its output, from values 1.4 times the true ones and phase 0, no stages.

    Here the kernel makes the records, which the twin holds in tests/simulation/test_block_library.py.
    """
    load = {
        "unbalance": {"amplitude": 0.08, "phase_deg": 30.0},
        "cable": {"law": "dahl", "stiffness": 0.05, "hysteresis": 0.02, "hysteresis_angle": 0.02},
    }
    m = mechanism_of(changed(paper_table(), {"housing": None, "load": load}))
    truth = {
        name: m.value(name)
        for name in (
            *WEIGHT_AND_CABLES,
            "stepper.torque_constant",
            "stepper.coil_inductance",
            "gear.stiffness",
            "gear.damping",
            "friction.coulomb",
            "friction.viscous",
        )
    }
    text = freed(mechanism_text(m), truth, off=1.4)
    text = re.sub(r"amplitude = \{ value = 0.112, min = 0.04", "amplitude = { value = 0.112, min = 0.0", text)
    text = re.sub(r"phase_deg = \{ value = 42.*?\}", "phase_deg = { value = 0.0, min = -180.0, max = 180.0 }", text)
    (tmp_path / "mechanism.toml").write_text(text)
    profile = "[[0.0, 0.0], [0.5, 300.0], [3.5, 300.0], [4.5, -300.0], [7.5, -300.0], [8.0, 0.0]]"
    runs = {
        "there_and_back": (8.0, f'stepping = "micro", microsteps = 16, rate_profile = {profile}'),
        "full_46": (2.0, 'stepping = "full", rate = 46.0, start_angle_deg = 45.0'),
    }
    lines = ['mechanism = "mechanism.toml"']
    for name, (_, command) in runs.items():
        lines += ["[[record]]", f'name = "{name}"', f'file = "{name}.csv"', f"command = {{ {command} }}"]
    (tmp_path / "campaign.toml").write_text("\n".join(lines) + "\n")
    made_by = load_campaign(tmp_path, read_records=False, need_files=False)
    rng = np.random.default_rng(3)
    for name, (seconds, _) in runs.items():
        made = replace(made_by, mechanism=m)
        run = simulate(made, name, sample_rate_hz=5000.0, duration_s=seconds, substeps=8)
        y = run.torque + rng.normal(0.01, 2e-3, run.torque.size)
        write_csv(tmp_path / f"{name}.csv", "time_s,torque_Nm", run.time, y)
    fit = identify(load_campaign(tmp_path))
    assert fit.grade in ("A", "B")
    assert_found(fit, truth, sigmas=3.0, largest=0.1)
    for record in fit.records.values():
        assert record.residual_rms == pytest.approx(2e-3, rel=0.03)


WINDING = ("motor.resistance", "motor.inductance", "motor.torque_constant")
SHAFT = ("motor.inertia", "friction.coulomb", "friction.viscous")
BRUSH_NOISE = {"current": 0.01, "rotor_rate": 0.5}


def brushed(folder, changes, free, quantities, *, seconds):
    """Write the campaign of a brushed motor under a measured voltage, from values 1.4 times the true ones; read it."""
    m = mechanism_of(
        changed({"assembly": "brushed_dc_drive", **BRUSHED_DC, "friction": {"coulomb": 5e-3, "viscous": 2e-5}}, changes)
    )
    m = replace(m, plant=m.plant.with_outputs(quantities))
    time_base, rng = base(seconds, rate_hz=2000.0), np.random.default_rng(5)
    t = time_base.times
    square = np.sign(np.sin(2 * np.pi * 23.0 * t))
    u = 3.0 * np.sin(2 * np.pi * 1.1 * t) + 2.0 * np.sin(2 * np.pi * 7.3 * t + 1.0) + square
    command = MeasuredCommand().driven_by((InputChannel(quantity="voltage", samples=u),), 2000.0, 0.0)
    noise = [BRUSH_NOISE[q] for q in quantities]
    y = run_twin(m, command, time_base).y + rng.normal(0.0, noise, (t.size, len(noise)))
    header = ",".join(["time_s", "u", *quantities])
    write_csv(folder / "run.csv", header, t, u, y)
    named = [f'  {{ quantity = "{q}", column = {k} }},' for k, q in enumerate(quantities, 2)]
    lines = [
        'mechanism = "mechanism.toml"',
        "[[record]]",
        'name = "run"',
        'file = "run.csv"',
        "channels = [",
        *named,
        '  { quantity = "voltage", column = 1, role = "input" },',
        "]",
    ]
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n")
    truth = {name: m.value(name) for name in free}
    (folder / "mechanism.toml").write_text(freed(mechanism_text(m), truth, off=1.4))
    return load_campaign(folder), truth


@pytest.mark.slow
def test_a_brushed_motor_is_found_from_current_and_rate(tmp_path):
    """All that a data sheet says of it 1.4 times off, no stages; back-EMF and torque constant are one."""
    campaign, truth = brushed(tmp_path, {}, (*WINDING, *SHAFT), ("current", "rotor_rate"), seconds=1.0)
    fit = identify(campaign)
    assert fit.grade in ("A", "B")
    assert_found(fit, truth, sigmas=3.0)
    for quantity, found in fit.records["run"].channels.items():
        assert found.residual_rms == pytest.approx(BRUSH_NOISE[quantity], rel=0.06)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "free", "quantities", "together"),
    [
        ({}, (*WINDING, *SHAFT), ("rotor_rate",), ("motor.resistance", "motor.inductance")),
        (
            {"motor": {"back_emf_constant": 0.045}},
            (*WINDING, *SHAFT, "motor.back_emf_constant"),
            ("current", "rotor_rate"),
            ("motor.torque_constant", *SHAFT),
        ),
    ],
)
def test_what_a_brushed_motor_s_records_cannot_tell_is_said(tmp_path, changes, free, quantities, together):
    """Truth, in closed form: without a current R and L go with 1/J; where k_e is free k_t goes with J."""
    campaign, _ = brushed(tmp_path, changes, free, quantities, seconds=1.0)
    fit = identify(campaign)
    reasons = [q.reason for q in fit.parameters.values() if "only combinations of them are seen" in q.reason]
    assert len(reasons) == 1
    assert all(name in reasons[0] for name in together)
