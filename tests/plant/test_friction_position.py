"""Dry friction over the angle. Truth: the balance of energy, the twin, and differences."""

from dataclasses import replace

import numpy as np

from layouts import mechanism_of
from mechid.command import InputChannel, MeasuredCommand
from runs import base, run_kernel, run_twin


def turning_on_uneven_friction(torque, seconds):
    """Return a body on friction that varies with its angle, its time base and its command of a constant torque."""
    m = mechanism_of(
        {
            "assembly": "direct_torque_drive",
            "load": {"inertia": 2e-3},
            "drive": {},
            "friction": {
                "coulomb": 0.05,
                "viscous": 0.0,
                "position": [{"order": 1, "amplitude": 0.6, "phase_deg": 40.0}],
            },
        }
    )
    time_base = base(seconds, rate_hz=1e3)
    channel = InputChannel(quantity="torque", held=True, samples=np.full(time_base.samples, torque))
    command = MeasuredCommand().driven_by((channel,), 1e3, 0.0)
    return replace(m, plant=m.plant.with_outputs(("output_angle", "output_rate"))), command, time_base


def test_friction_that_varies_with_the_angle_keeps_the_balance_of_energy():
    """Truth: J v^2/2 = (T - T_c) x + T_c A (cos(x + phi) - cos(phi)), the work of a constant torque less friction's."""
    run, phi = run_kernel(*turning_on_uneven_friction(0.09, 0.8), substeps=4).values, np.radians(40.0)
    x, v = run["output_angle"], run["output_rate"]
    assert x[-1] > 2.0
    work = (0.09 - 0.05) * x + 0.05 * 0.6 * (np.cos(x + phi) - np.cos(phi))
    np.testing.assert_allclose(2e-3 * v**2 / 2, work, rtol=0, atol=1e-8 * work.max())
    still = run_kernel(*turning_on_uneven_friction(0.069, 0.1), substeps=4).values
    assert np.all(still["output_angle"] == 0.0), "friction is 0.05 (1 + 0.6 sin 40 deg) = 0.0693 there"


def test_friction_over_the_angle_has_its_derivatives():
    """Truth: the twin's variational equations, and central differences."""
    m, command, time_base = turning_on_uneven_friction(0.09, 0.8)
    chosen = [list(map(str, m.plant.parameters)).index(name) for name in ("T_frd", "c_f1", "s_f1")]
    kernel = run_kernel(m, command, time_base, sensitive=chosen, substeps=8).jacobian["output_angle"]
    twin = run_twin(m, command, time_base, sensitive=chosen).jacobian[:, 0]
    assert np.all(np.linalg.norm(kernel - twin, axis=0) <= 1e-5 * np.linalg.norm(twin, axis=0))
    p = m.kernel_values()
    for j, i in enumerate(chosen):
        step = 1e-6 * np.eye(p.size)[i]
        runs = (run_kernel(m, command, time_base, p=p + way * step, substeps=8).values for way in (1, -1))
        up, down = (run["output_angle"] for run in runs)
        np.testing.assert_allclose((up - down) / 2e-6, kernel[:, j], rtol=0, atol=1e-4 * np.abs(kernel[:, j]).max())
