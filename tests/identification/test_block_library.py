"""Fits with the library's blocks. Truth: values that made the records, run by the slow twin, noise added."""

import numpy as np
import pytest

from freed import assert_found, freed
from layouts import changed, mechanism_of, paper_table
from mechid.campaign import load_campaign, mechanism_text
from mechid.command import InputChannel, MeasuredCommand
from mechid.identification.identify import identify
from paper import constant
from runs import base, run_twin


def test_a_direct_drive_is_found_from_force_and_position(tmp_path):
    truth = {"load.mass": 95.0, "friction.coulomb": 20.0, "friction.viscous": 200.0, "drive.offset": -3.0}
    m = mechanism_of({
        "assembly": "direct_force_drive", "load": {"mass": 95.0}, "drive": {"offset": -3.0},
        "friction": {"static": 25.0, "coulomb": 20.0, "viscous": 200.0},
    })  # fmt: skip
    time_base, rng = base(4.0, rate_hz=1e3), np.random.default_rng(11)
    t = time_base.times
    force = 3.0 + 60.0 * np.sin(2 * np.pi * 0.7 * t) + 50.0 * np.sin(2 * np.pi * 2.3 * t + 1.0)
    command = MeasuredCommand().driven_by((InputChannel(quantity="force", samples=force),), 1e3, 0.0)
    x = run_twin(m, command, time_base).y[:, 0] + rng.normal(0.0, 2e-5, t.size)
    np.savetxt(
        tmp_path / "run.csv", np.stack([t, force, x], axis=1), delimiter=",", header="time_s,F_N,x_m", comments=""
    )
    (tmp_path / "mechanism.toml").write_text(freed(mechanism_text(m), truth))
    (tmp_path / "campaign.toml").write_text(
        'mechanism = "mechanism.toml"\n[[record]]\nname = "run"\nfile = "run.csv"\nchannels = [\n'
        '  { quantity = "position", column = "x" },\n  { quantity = "force", column = "F", role = "input" },\n]\n'
        f'[[stage]]\nrecords = ["run"]\nfree = [{", ".join(f"""{chr(34)}{name}{chr(34)}""" for name in truth)}]\n'
    )
    fit = identify(load_campaign(tmp_path))
    assert_found(fit, truth)
    assert fit.records["run"].residual_rms == pytest.approx(2e-5, rel=0.05)


def test_a_test_stand_is_found_with_the_mechanism(tmp_path):
    """Transducer resonance by its adaptor, gain, charge amplifier and anti-alias filter, shared by two records."""
    stand = {
        "transducer": {"law": "adaptor", "gain": -1.1, "stiffness": 2.0e4, "adaptor_inertia": 1e-4, "damping": 0.05},
        "charge_amplifier": {"time_constant": 0.15},
        "anti_alias": {"frequency": 16000.0, "order": 4},
    }
    m = mechanism_of(changed(paper_table(), stand))
    truth = {name: m.value(name) for name in (
        "transducer.gain", "transducer.adaptor_inertia", "transducer.damping", "charge_amplifier.time_constant",
        "anti_alias.frequency", "stepper.torque_constant", "gear.stiffness", "gear.damping", "housing.frequency",
    )}  # fmt: skip
    rng, time_base = np.random.default_rng(12), base(0.6)
    records = {"full_5": (5.0, 1), "full_46": (46.0, 1)}
    lines = ['mechanism = "mechanism.toml"']
    for name, (rate, microsteps) in records.items():
        y = run_twin(m, constant(rate, microsteps=microsteps), time_base).y[:, 0]
        y = y + rng.normal(0.0, 2e-3, y.size) + 0.01
        np.savetxt(tmp_path / f"{name}.csv", np.stack([time_base.times, y], axis=1), delimiter=",",
                   header="time_s,torque_Nm", comments="")  # fmt: skip
        lines += ["[[record]]", f'name = "{name}"', f'file = "{name}.csv"', "drift = false",
                  f'command = {{ stepping = "full", rate = {rate}, start_angle_deg = 45.0 }}']  # fmt: skip
    names = ", ".join(f'"{name}"' for name in truth)
    for window in ("window_s = [0.0, 0.03]", "window_s = [0.0, 0.15]", ""):
        lines += ["[[stage]]", window, f"free = [{names}]"]
    (tmp_path / "campaign.toml").write_text("\n".join(lines) + "\n")
    (tmp_path / "mechanism.toml").write_text(freed(mechanism_text(m), truth, off=1.01))
    fit = identify(load_campaign(tmp_path))
    assert_found(fit, truth, largest=0.2)
    for record in fit.records.values():
        assert record.residual_rms == pytest.approx(2e-3, rel=0.05)
