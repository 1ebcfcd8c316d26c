"""The stepper motor. Truth: the paper's equations for given currents."""

import numpy as np
import pytest

from hand_typed import motor_torque
from layouts import LAYOUTS, paper_with
from mechid.kernel.equations import equations_of
from random_states import entered, random_state, values


def test_an_ideal_current_source_leaves_the_torque_of_its_currents():
    """Truth: the paper's equations with i_A = -I cos(theta), i_B = I sin(theta) in place of the windings."""
    m = paper_with({**LAYOUTS["current drive"], "housing": None})
    q, equations = values(m), equations_of(m.plant)
    x, u = random_state(m, 3)
    state = [x[str(s)] for s in m.plant.states]
    at = (state, u, entered(equations, state, u, m.kernel_values()), m.kernel_values())
    T_mot = motor_torque((0.5 * u[0], 0.5 * u[1], x["alpha"]), q, (4, 2))
    T_rg = q["K_s"] / 2500 * (x["alpha"] - 50 * x["alpha_gear"]) + q["D"] / 2500 * (x["omega"] - 50 * x["omega_gear"])
    T_fr = q["T_frd"] * np.sign(x["omega"]) + q["T_visc"] * x["omega"]
    rate = equations.rates(*at)[[str(s) for s in m.plant.states].index("omega")]
    assert rate == pytest.approx((T_mot - T_fr - T_rg) / q["J_rot"], rel=1e-10)
