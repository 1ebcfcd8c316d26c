"""Friction laws. Truth: the margins of a stuck body, typed by hand."""

import numpy as np
import pytest

from hand_typed import motor_torque
from hand_typed_blocks import (
    friction_torque,
    kinematics,
    output_torque,
)
from layouts import LAYOUTS, paper_with
from mechid.kernel.equations import equations_of
from random_states import entered, random_state, rubbing

SEEDS = range(12)


@pytest.mark.parametrize(
    "name", ["stribeck", "directional", "load_dependent", "friction position", "friction by direction"]
)
def test_a_body_at_rest_is_held_up_to_the_law_s_limit(name):
    """Truth: `hand_typed_blocks`: the margins of the stuck mode are what is held, less the torque to be held."""
    m = paper_with({**LAYOUTS[name], "housing": None})
    equations = equations_of(m.plant)
    for seed in SEEDS:
        x, u = random_state(m, seed)
        x["omega"], q = 0.0, rubbing(name, m, x)
        state = [x[str(s)] for s in m.plant.states]
        twist, twist_rate, lever = kinematics(x["alpha"], 0.0, x["alpha_gear"], x["omega_gear"], (), q)
        T_rg = lever * output_torque("linear", twist, twist_rate, q)
        drive = motor_torque((x["i_A"], x["i_B"], x["alpha"]), q, (4, 2)) - T_rg
        held = [friction_torque(name, 1.0, 0.0, T_rg, 0.0, rubbing(name, m, x, way))[1] for way in (1, -1)]
        up, down = held[0][0], held[1][1]
        at = (state, u, entered(equations, state, u, m.kernel_values()), m.kernel_values())
        np.testing.assert_allclose(equations.margins[0][0](*at), [up - drive, down + drive], rtol=1e-9, atol=1e-15)
