"""The assemblies of the library. Truth: their equations of motion typed by hand."""

from dataclasses import replace

import numpy as np
import pytest
from sympy import Symbol

from layouts import BRUSHED_DC, mechanism_of
from mechid.kernel.equations import equations_of
from mechid.plant.assembly import plant_of, stepper_gear_mass
from mechid.plant.layout import Layout
from paper import mechanism
from random_states import entered


def test_the_paper_s_plant_is_that_of_its_blocks_written_out():
    """Truth: the layout that names every default; the structure's digest, by which kernels are found."""
    spelt = plant_of(
        Layout(
            laws={"stepper": "voltage", "friction": "coulomb", "gear": "linear", "housing": "paper"},
            orders={"stepper.detent": (4, 2)},
            tables=frozenset({"housing"}),
        )
    )
    assert spelt.digest == stepper_gear_mass((4, 2), "paper").digest == mechanism().plant.digest


@pytest.mark.parametrize(
    ("quantity", "inertia", "output"), [("force", "mass", "position"), ("torque", "inertia", "output_angle")]
)
def test_a_direct_drive_is_a_mass_on_friction(quantity, inertia, output):
    """Truth: m x'' = F + F_0 - F_c sign(x') - F_v x'; the output is x."""
    table = {
        "load": {inertia: 95.0},
        "friction": {"static": 25.0, "coulomb": 20.0, "viscous": 200.0},
        "drive": {"offset": -3.0},
        "assembly": f"direct_{quantity}_drive",
    }
    m = mechanism_of(table)
    assert list(m.plant.outputs) == [output]
    equations = equations_of(m.plant)
    x, u, p = [7.0, 0.3, -0.1], [40.0, 0.0], m.kernel_values()
    rates = equations.rates(x, u, entered(equations, x, u, p), p)
    np.testing.assert_allclose(rates, [0.0, -0.1, (40.0 + 7.0 - 3.0 + 20.0 + 20.0) / 95.0], rtol=1e-12)
    assert equations.outputs(x, u, entered(equations, x, u, p), p)[0] == 0.3


def test_an_unbalanced_axis_is_a_pendulum_that_may_begin_in_motion():
    """Truth: J a'' = T + T_0 - W sin(a) - T_c sign(a') - T_v a'; a'(0) is the start rate."""
    table = {
        "load": {"inertia": 0.06, "unbalance": 1.5, "start_rate": 0.7},
        "drive": {"offset": -0.1},
        "friction": {"coulomb": 0.2, "viscous": 0.05},
        "assembly": "direct_torque_drive",
    }
    m = mechanism_of(table)
    equations = equations_of(m.plant)
    x, u, p = [0.4, 0.8, -2.0], [1.1, 0.0], m.kernel_values()
    rates = equations.rates(x, u, entered(equations, x, u, p), p)
    expected = (1.1 + 0.4 - 0.1 - 1.5 * np.sin(0.8) + 0.2 + 0.05 * 2.0) / 0.06
    np.testing.assert_allclose(rates, [0.0, -2.0, expected], rtol=1e-12)
    assert list(m.plant.initial) == [0, 0, Symbol("omega_start")]


@pytest.mark.parametrize("spring", [{}, {"spring": {"stiffness": 0.05, "rest_angle": 0.3}}])
def test_a_brushed_motor_is_a_winding_and_a_shaft(spring):
    """Truth: L i' = u + u_0 - R i - k_e w, J w' = k_t i - T_c sign(w) - b w - K (a - a_0); the base feels -J w'."""
    m = mechanism_of({"assembly": "brushed_dc_drive", **BRUSHED_DC, **spring})
    assert m.parameters["motor.back_emf_constant"].tied_to == "motor.torque_constant"
    m = replace(m, plant=m.plant.with_outputs(("rotor_angle", "rotor_rate", "current", "torque")))
    equations, p = equations_of(m.plant), m.kernel_values()
    states = {"voltage_ramp": 1.0, "i_mot": 0.7, "alpha": -0.4, "omega": -3.0}
    x, u = [states[str(s)] for s in m.plant.states], [5.0, 0.0]
    mode = entered(equations, x, u, p)
    rate = dict(zip(map(str, m.plant.states), equations.rates(x, u, mode, p), strict=True))
    pull = 0.05 * (-0.4 - 0.3) if spring else 0.0
    torque = 0.045 * 0.7 + 5e-3 + 2e-5 * 3.0 - pull
    assert rate["i_mot"] == pytest.approx((5.0 + 1.0 + 0.02 - 2.3 * 0.7 + 0.045 * 3.0) / 1.5e-3, rel=1e-12)
    assert (rate["alpha"], rate["omega"]) == pytest.approx((-3.0, torque / 4e-5), rel=1e-12)
    np.testing.assert_allclose(equations.outputs(x, u, mode, p), [-0.4, -3.0, 0.7, -torque], rtol=1e-12)
    assert equations.initial([0.0], u, mode, p)[list(map(str, m.plant.states)).index("i_mot")] == 5.02 / 2.3
