"""The library's blocks in the paper's mechanism, against right-hand sides typed by hand from their references."""

import numpy as np
import pytest

from hand_typed import motor_torque
from hand_typed_blocks import (
    detent_lag,
    detents_over_temperature,
    driven,
    flexible_load,
    friction_torque,
    kinematics,
    load_torques,
    output_torque,
    stiffness_variation,
    supplied,
    winding_rates,
)
from layouts import LAYOUTS, paper_with
from mechid.kernel.equations import equations_of
from random_states import entered, random_state, rubbing

SEEDS = range(12)
ELSEWHERE = ("current drive", "current limit", "test stand", "output_friction", "second mode", "three switches")
CASES = [name for name in LAYOUTS if name not in ELSEWHERE]


def orders_of(m, table):
    """Return the orders of a list of harmonics, as the mechanism has them."""
    return tuple(m.value(f"{table}.{k}.order") for k in range(m.plant.layout.count(table)))


def by_hand(name, m, x, u):
    """Return the rates of all states by name."""
    q, orders, varied = (
        rubbing(name, m, x),
        orders_of(m, "gear.kinematic_error"),
        orders_of(m, "gear.stiffness_variation"),
    )
    harmonics = tuple(h["order"] for h in LAYOUTS[name].get("stepper", {}).get("torque_harmonic", ()))
    u = driven(u, tuple(h["order"] for h in LAYOUTS[name].get("stepper", {}).get("microstep_table", ())), q)
    twist, twist_rate, lever = kinematics(x["alpha"], x["omega"], x["alpha_gear"], x["omega_gear"], orders, q)
    T_out = output_torque(name, twist, twist_rate, q)
    # A spring of energy K (1 + v) twist^2 / 2 pulls at both ends by its derivatives.
    variation, slope = stiffness_variation(x["alpha"], varied, q)
    T_out += variation * q.get("K_s", 0.0) * twist
    T_rg, direction = lever * T_out + slope * q.get("K_s", 0.0) * twist**2 / 2, np.sign(x["omega"])
    T_fr, slip = friction_torque(name, direction, x["omega"], T_rg, x.get("z_fr", 0.0), q)
    di_A, di_B, T_coils = winding_rates(
        (x["i_A"], x["i_B"]), supplied(u, (x["i_A"], x["i_B"]), q), x["alpha"], x["omega"], q, harmonics
    )
    T_mot = T_coils + detents_over_temperature(q) * motor_torque((0.0, 0.0, x["alpha"]), q, (4, 2))
    lag, lag_rate = detent_lag(x["omega"], x.get("h_detent", 0.0), q)
    T_mot -= lag
    modes = [(x[f"q_{k}"], x[f"v_{k}"]) for k in (1, 2) if f"q_{k}" in x]
    cable, h_rate, weight = load_torques(name, x["alpha_gear"], x["omega_gear"], x.get("h_cable", 0.0), q)
    a_gear, *a_modes = flexible_load(T_out - cable - weight, modes, q)
    rates = {
        "i_A": di_A,
        "i_B": di_B,
        "alpha": x["omega"],
        "omega": (T_mot - T_fr - T_rg) / q["J_rot"],
        "alpha_gear": x["omega_gear"],
        "omega_gear": a_gear,
    }
    if "z_fr" in x:
        rates["z_fr"] = slip
    if "h_detent" in x:
        rates["h_detent"] = lag_rate
    if "h_cable" in x:
        rates["h_cable"] = h_rate
    for k, a in enumerate(a_modes, start=1):
        rates |= {f"q_{k}": x[f"v_{k}"], f"v_{k}": a}
    return rates, -(q["J_rot"] * rates["omega"] + T_out - cable)  # what the weight pulls the base feels


@pytest.mark.parametrize("name", CASES)
def test_rates_and_torque_are_those_typed_by_hand(name):
    """Truth: `hand_typed_blocks`; in whatever mode the state is, which by hand follows from the state alone."""
    m = paper_with({**LAYOUTS[name], "housing": None})
    equations = equations_of(m.plant)
    for seed in SEEDS:
        x, u = random_state(m, seed)
        state = [x[str(s)] for s in m.plant.states]
        at = (state, u, entered(equations, state, u, m.kernel_values()), m.kernel_values())
        rates, torque = by_hand(name, m, x, u)
        expected = [rates[str(s)] for s in m.plant.states]
        np.testing.assert_allclose(equations.rates(*at), expected, rtol=1e-9, atol=1e-12)
        assert equations.outputs(*at)[0] == pytest.approx(torque, rel=1e-9)
