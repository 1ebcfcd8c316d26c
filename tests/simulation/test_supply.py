"""A source that sags. Truth: settled currents in closed form, the twin, differences."""

import numpy as np
import pytest

from layouts import LAYOUTS, changed, paper_with
from mechid.kernel.equations import equations_of
from paper import constant
from runs import base, run_kernel, run_twin

RIGID = {"housing": None}
APART = LAYOUTS["imbalance"]["stepper"]
SAGGING = {**RIGID, "supply": {"resistance": 1.4}}


@pytest.mark.parametrize("apart", [{}, {"stepper": APART}])
def test_currents_begin_settled_behind_the_source(apart):
    """Truth: the rates of the currents are zero there, at rest; and one phase alone carries U/(R + R_s)."""
    m = paper_with(changed(SAGGING, apart))
    equations, p = equations_of(m.plant), m.kernel_values()
    names = list(map(str, m.plant.states))
    for theta in (0.0, 0.4, 2.0):
        u, resting = np.array([-np.cos(theta), np.sin(theta)]), (0.0, 0.0)
        x = equations.initial([theta], u, resting, p)
        rates = equations.rates(x, u, resting, p)
        np.testing.assert_allclose([rates[names.index(f"i_{phase}")] for phase in "AB"], 0.0, atol=1e-9)
    if not apart:
        x = equations.initial([0.0], np.array([-1.0, 0.0]), (0.0, 0.0), p)
        assert x[names.index("i_A")] == pytest.approx(-5.7 / (9.9 + 1.4), rel=1e-12)


@pytest.mark.slow
def test_its_resistance_has_its_derivative():
    """Truth: the twin's variational equations, and central differences; at an ideal source one to the right."""
    command, time_base = constant(46.0, microsteps=4), base(0.06)
    for resistance in (1.4, 0.0):
        m = paper_with({**RIGID, "supply": {"resistance": resistance}})
        i = list(map(str, m.plant.parameters)).index("R_s")
        kernel = run_kernel(m, command, time_base, sensitive=[i], substeps=8).jacobian["torque"][:, 0]
        twin = run_twin(m, command, time_base, sensitive=[i]).jacobian[:, 0, 0]
        assert np.linalg.norm(kernel - twin) <= 1e-5 * np.linalg.norm(twin)
        p = m.kernel_values()
        step = 1e-5 * np.eye(p.size)[i]
        up, down = (run_kernel(m, command, time_base, p=p + way * step, substeps=8).torque for way in (1, -1))
        off = np.abs((up - down) / 2e-5 - kernel) > 1e-4 * np.abs(kernel).max()
        assert off.sum() <= 5
