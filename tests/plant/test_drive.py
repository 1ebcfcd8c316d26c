"""Drives on a command or on measured channels. Truth: closed forms, and the same voltages from a command."""

import numpy as np
import pytest

from layouts import mechanism_of, paper_with
from mechid.command import InputChannel, MeasuredCommand
from paper import constant
from runs import base, rms, run_kernel


@pytest.mark.parametrize("held", [True, False])
def test_a_measured_input_is_held_or_runs_straight_between_its_samples(held):
    """Truth: m x'' = F in closed form, F the steps or the straight lines through the samples."""
    m = mechanism_of(
        {
            "assembly": "direct_torque_drive",
            "load": {"inertia": 2e-3},
            "drive": {},
            "friction": {"static": 0.0, "coulomb": 0.0, "viscous": 0.0},
        }
    )
    time_base, r = base(0.05, rate_hz=1e3, start_s=3.0), np.random.default_rng(4)
    F, h = r.normal(size=time_base.samples), 1e-3
    command = MeasuredCommand().driven_by((InputChannel(quantity="torque", held=held, samples=F),), 1e3, 3.0)
    slope = np.zeros_like(F) if held else np.append(np.diff(F), 0.0) / h
    v = np.concatenate([[0.0], np.cumsum(F * h + slope * h**2 / 2)[:-1]]) / 2e-3
    x = np.concatenate([[0.0], np.cumsum(v * h + (F * h**2 / 2 + slope * h**3 / 6) / 2e-3)[:-1]])
    kernel = run_kernel(m, command, time_base, substeps=1)
    np.testing.assert_allclose(kernel.measured, x, rtol=0, atol=1e-9 * np.abs(x).max())


@pytest.mark.slow
def test_a_stepper_on_measured_voltages_is_that_on_its_command():
    """Truth: the same mechanism under the command whose voltages, held from sample to sample, are the channels."""
    rigid = {"housing": None}
    commanded = paper_with(rigid)
    measured = paper_with({**rigid, "stepper": {"drive": "measured_voltage", "peak_voltage": None}})
    time_base, command = base(0.1), constant(50.0)
    theta = np.pi / 4 + np.pi / 2 * np.floor(time_base.times * 50.0 + 1e-9)
    channels = tuple(
        InputChannel(quantity=f"voltage_phase_{x}", held=True, samples=5.7 * wave)
        for x, wave in (("a", -np.cos(theta)), ("b", np.sin(theta)))
    )
    driven = MeasuredCommand(start_angle_deg=45.0).driven_by(channels, 10_000.0, 0.0)
    expected = run_kernel(commanded, command, time_base).torque
    assert rms(run_kernel(measured, driven, time_base).torque - expected) <= 1e-5 * rms(expected)
