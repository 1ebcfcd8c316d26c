"""A current drive that runs out of voltage. Truth: exponentials of a coil, the ideal drive, the twin, differences."""

import numpy as np
import pytest

from layouts import LAYOUTS, changed, paper_with
from paper import constant
from runs import base, rms, run_kernel, run_twin

RIGID = {"housing": None}
LIMITED = {**RIGID, **LAYOUTS["current limit"]}
HELD = {"friction": {"static": 50.0, "coulomb": 50.0}}
"""Friction that nothing moves."""


def limit(**values):
    return changed(LIMITED, {"stepper": {"current_limit": values}})


@pytest.mark.slow
def test_a_coil_at_rest_fills_by_its_exponential():
    """Truth: i = U/R - (U/R + I sin 45 deg) exp(-t R/L) up to I sin 45 deg, which it then holds."""
    m = paper_with(changed(LIMITED, HELD))
    m = m.__class__(m.plant.with_outputs(("current_phase_a", "current_phase_b")), m.parameters, m.options)
    time_base, I = base(0.03), 0.5 * np.sqrt(0.5)
    run = run_kernel(m, constant(50.0), time_base).values
    since = np.maximum(time_base.times - 0.02, 0.0)
    filled = 12.0 / 9.9 - (12.0 / 9.9 + I) * np.exp(-since * 9.9 / 0.045)
    np.testing.assert_allclose(run["current_phase_a"], np.where(since > 0.0, np.minimum(filled, I), -I), atol=1e-7)
    np.testing.assert_allclose(run["current_phase_b"], I, atol=1e-7)


@pytest.mark.slow
def test_with_much_voltage_it_is_the_ideal_drive():
    """Truth: the ideal drive, at a supply that fills the coils in less than a microsecond.

    Behind the housing, where no torque jumps: a sample at a jump is the mean over its interval.
    """
    command, time_base = constant(46.0, microsteps=4), base(0.1)
    expected = run_kernel(paper_with(LAYOUTS["current drive"]), command, time_base).torque
    much = changed(LAYOUTS["current limit"], {"stepper": {"current_limit": {"voltage": 1.2e5}}})
    torque = run_kernel(paper_with(much), command, time_base, substeps=8).torque
    assert rms(torque - expected) <= 1e-3 * rms(expected)


@pytest.mark.slow
def test_an_emf_beyond_the_supply_takes_current_away():
    """Truth: the twin, at a supply that hardly holds the coils at rest: loops leave their current between steps."""
    m = paper_with(limit(voltage=5.2))
    command, time_base = constant(90.0, microsteps=4), base(0.1)
    kernel, twin = run_kernel(m, command, time_base, substeps=8), run_twin(m, command, time_base)
    assert rms(kernel.torque - twin.y[:, 0]) <= 1e-5 * rms(twin.y)


@pytest.mark.parametrize("microsteps", [1, 4])
def test_kernel_and_derivatives_are_those_of_the_twin(microsteps):
    """Truth: the twin, its variational equations, and central differences."""
    m, command, time_base = paper_with(LIMITED), constant(46.0, microsteps=microsteps), base(0.06)
    chosen = [list(map(str, m.plant.parameters)).index(name) for name in ("U_loop", "R_loop", "L_loop", "I_peak")]
    run = run_kernel(m, command, time_base, sensitive=chosen, substeps=8)
    twin = run_twin(m, command, time_base, sensitive=chosen)
    assert rms(run.torque - twin.y[:, 0]) <= 1e-5 * rms(twin.y)
    kernel, slopes = run.jacobian["torque"], twin.jacobian[:, 0]
    assert np.all(np.linalg.norm(kernel - slopes, axis=0) <= 1e-5 * np.linalg.norm(slopes, axis=0))
    p = m.kernel_values()
    for j, i in enumerate(chosen):
        step = 1e-5 * abs(p[i]) * np.eye(p.size)[i]
        up, down = (run_kernel(m, command, time_base, p=p + way * step, substeps=8).torque for way in (1, -1))
        difference = (up - down) / (2 * step[i])
        off = np.abs(difference - kernel[:, j]) > 1e-4 * np.abs(difference).max()
        assert off.sum() <= 5, m.plant.parameters[i]
