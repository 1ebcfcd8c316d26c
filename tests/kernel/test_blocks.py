"""The library's blocks in the paper's mechanism, against right-hand sides typed by hand from their references."""

from dataclasses import replace

import numpy as np
import pytest
from sympy import Symbol

from hand_typed import motor_torque
from hand_typed_blocks import (
    driven,
    flexible_load,
    friction_torque,
    housing_response,
    kinematics,
    load_torques,
    output_torque,
    stand_response,
    supplied,
    varied_friction,
    winding_rates,
)
from layouts import BRUSHED_DC, LAYOUTS, mechanism_of, paper_with
from mechid.kernel.equations import equations_of
from mechid.plant.assembly import plant_of, stepper_gear_mass
from mechid.plant.layout import Layout
from paper import mechanism

SEEDS = range(12)
ELSEWHERE = ("current drive", "current limit", "test stand", "output_friction", "second mode", "three switches")
CASES = [name for name in LAYOUTS if name not in ELSEWHERE]


def values(m):
    return dict(zip(map(str, m.plant.parameters), m.kernel_values(), strict=True))


def random_state(m, seed):
    """Return states by name, of the size a run meets; the gear is twisted by up to 4e-4 rad."""
    r = np.random.default_rng(seed)
    scale = {
        "i_A": 0.5,
        "i_B": 0.5,
        "omega": 8.0,
        "z_fr": 1e-3,
        "q_1": 1e-3,
        "q_2": 1e-4,
        "v_1": 0.2,
        "v_2": 0.1,
        "h_cable": 0.5,
    }
    x = {str(s): scale.get(str(s), 0.0) * r.normal() for s in m.plant.states}
    x["alpha"] = r.uniform(-3, 3)
    x["alpha_gear"] = x["alpha"] / 50 + r.uniform(-4e-4, 4e-4)
    x["omega_gear"] = x["omega"] / 50 + 0.05 * r.normal()
    angle = r.uniform(0, 2 * np.pi)
    return x, np.array([-np.cos(angle), np.sin(angle)])


def entered(equations, x, u, p):
    """Return the mode symbols that the plant's own entry rules choose at a state, as a run would at its start."""
    plant, modes = equations.plant, [0] * len(equations.plant.switches)
    for k in (*range(len(modes)), *range(len(modes))):
        rules = equations.entry[k](x, u, equations.mode_symbols(modes), p)
        switch = plant.switches[k]
        chosen = next((mode for (_, mode), v in zip(switch.entry, rules, strict=True) if v > 0), switch.otherwise)
        modes[k] = list(switch.modes).index(chosen)
    return equations.mode_symbols(modes)


def rubbing(name, m, x):
    """Return the kernel's parameters by name, friction as it is at a state's angles."""
    lists = LAYOUTS[name].get("friction", {})
    orders = (tuple(h["order"] for h in lists.get(key, ())) for key in ("position", "output_position"))
    return varied_friction(*orders, x["alpha"], x["alpha_gear"], values(m))


def by_hand(name, m, x, u):
    """Return the rates of all states by name."""
    q, orders = rubbing(name, m, x), tuple(k["order"] for k in LAYOUTS[name].get("gear", {}).get("kinematic_error", ()))
    harmonics = tuple(h["order"] for h in LAYOUTS[name].get("stepper", {}).get("torque_harmonic", ()))
    u = driven(u, tuple(h["order"] for h in LAYOUTS[name].get("stepper", {}).get("microstep_table", ())), q)
    twist, twist_rate, lever = kinematics(x["alpha"], x["omega"], x["alpha_gear"], x["omega_gear"], orders, q)
    T_out = output_torque(name, twist, twist_rate, q)
    T_rg, direction = lever * T_out, np.sign(x["omega"])
    T_fr, slip = friction_torque(name, direction, x["omega"], T_rg, x.get("z_fr", 0.0), q)
    di_A, di_B, T_coils = winding_rates(
        (x["i_A"], x["i_B"]), supplied(u, (x["i_A"], x["i_B"]), q), x["alpha"], x["omega"], q, harmonics
    )
    T_mot = T_coils + motor_torque((0.0, 0.0, x["alpha"]), q, (4, 2))
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


def test_a_gear_with_kinematic_error_starts_unwound():
    """Truth: `hand_typed_blocks`: no twist at the start, whatever the error; its derivatives by differences."""
    layout = LAYOUTS["kinematic_error"]
    m = paper_with(layout)
    orders = tuple(k["order"] for k in layout["gear"]["kinematic_error"])
    start, p, theta_0 = equations_of(m.plant).initial, m.kernel_values(), np.radians(2000.0)
    others = np.zeros(len(m.plant.inputs)), (0.0, 0.0)

    def begun(p):
        return start((theta_0,), *others, p)

    x = dict(zip(map(str, equations_of(m.plant).states), begun(p), strict=True))
    twist, _, _ = kinematics(x["alpha"], 0.0, x["alpha_gear"], 0.0, orders, values(m))
    assert x["alpha"] == pytest.approx(theta_0 / 50.0, rel=1e-12)
    assert abs(x["alpha_gear"] - x["alpha"] / 50.0) > 1e-5
    assert abs(twist) < 1e-16
    slopes = start.by_parameter((theta_0,), *others, p)
    for k, step in enumerate(1e-6 * np.maximum(np.abs(p), 1e-4)):
        move = step * np.eye(p.size)[k]
        np.testing.assert_allclose((begun(p + move) - begun(p - move)) / (2 * step), slopes[:, k], rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("name", ["stribeck", "directional", "load_dependent", "friction position"])
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
        _, (up, down) = friction_torque(name, 1.0, 0.0, T_rg, 0.0, q)
        at = (state, u, entered(equations, state, u, m.kernel_values()), m.kernel_values())
        np.testing.assert_allclose(equations.margins[0][0](*at), [up - drive, down + drive], rtol=1e-9, atol=1e-15)


def test_the_test_stand_s_response_is_that_of_its_parts_in_a_row():
    """Truth: transfer functions by hand, the Butterworth filter by its poles on a circle; for a torque of the base."""
    m = paper_with({**LAYOUTS["test stand"], "housing": None})
    q, system = values(m), m.plant.filter
    named = {str(s): v for s, v in zip(m.plant.parameters, m.kernel_values(), strict=True)}
    A, B = (np.array(matrix.subs(named), dtype=float) for matrix in (system.A, system.B))
    (seen,) = m.plant.outputs.values()
    C = np.array([float(seen.diff(s).subs(named)) for s in system.states])
    T = {"T_res": -1.0, "T_rg": -q["G"]}  # y = -(T_res + G T_rg)
    for hz in (0.05, 3.0, 300.0, 2500.0, 4000.0):
        s = 2j * np.pi * hz
        z = np.linalg.solve(s * np.eye(len(A)) - A, B)
        for j, u in enumerate(map(str, system.inputs)):
            assert C @ z[:, j] == pytest.approx(stand_response(s, T[u], q, 5), rel=1e-9)


@pytest.mark.parametrize("form", ["paper", "unit_dc"])
def test_a_housing_of_two_modes_is_their_sum(form):
    """Truth: transfer functions by hand, the second mode's gain of either sign."""
    second = {"gain": -0.8, "frequency": 2500.0, "damping": 0.04}
    m = paper_with({"housing": {"form": form, "second_mode": second}})
    named = {str(s): v for s, v in zip(m.plant.parameters, m.kernel_values(), strict=True)}
    system = m.plant.filter
    A, B = (np.array(matrix.subs(named), dtype=float) for matrix in (system.A, system.B))
    seen = m.plant.outputs["torque"].subs(named)
    C = np.array([float(seen.diff(s)) for s in system.states])
    k = list(map(str, system.inputs)).index("T_res")
    through = float(seen.diff(Symbol("T_res")))
    for hz in (0.1, 200.0, 397.9, 700.0, 888.0, 3000.0):
        s = 2j * np.pi * hz
        z = np.linalg.solve(s * np.eye(len(A)) - A, B)
        modes = ((4.6, 5578.0, 0.095), (-0.8, 2500.0, 0.04))
        assert C @ z[:, k] + through == pytest.approx(housing_response(s, -1.0, form, modes), rel=1e-9)


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
    m = replace(m, plant=m.plant.measuring(("rotor_angle", "rotor_rate", "current", "torque")))
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
