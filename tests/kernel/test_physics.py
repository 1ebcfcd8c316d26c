"""Kernel and twin against the mechanism typed by hand from the paper, at seeded random states, in all modes."""

import numpy as np
import pytest

from hand_typed import MODES, differentiated, gear_torque, motor_torque, random_state, right_hand_side
from kernel_state import evaluated
from mechid.kernel.equations import equations_of
from paper import indices, mechanism

HOUSINGS = ("paper", "unit_dc", None)
DETENTS = ((4, 2), (), (4, None), (3,))
SEEDS = range(8)


def case(housing, seed, orders=(4, 2), ratio=50.0):
    m = mechanism(housing, orders, {"gear.ratio": ratio})
    x, z, u = random_state(seed)
    q = dict(zip(map(str, m.plant.parameters), m.kernel_values(), strict=True))
    return m, x, z[: len(m.plant.filter.states)], u, q


def assert_close(found, expected):
    """Equal to 1e-11 of the largest entry of each row: what float arithmetic leaves of a sum of such terms."""
    found, expected = np.atleast_2d(found), np.atleast_2d(expected)
    scale = np.abs(expected).max(axis=-1, keepdims=True)
    assert np.all(np.abs(found - expected) <= 1e-11 * scale), np.abs(found - expected) / scale


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("housing", ["paper", pytest.param("unit_dc", marks=pytest.mark.slow), None])
def test_the_kernel_s_rates_are_those_typed_by_hand(housing, mode):
    """Truth: `hand_typed`, its derivatives by complex steps."""
    assert_kernel_agrees(housing, mode, (4, 2), 50.0)


@pytest.mark.slow  # each compiles a kernel of its own
@pytest.mark.parametrize("orders", [orders for orders in DETENTS if orders != (4, 2)], ids=str)
def test_kernels_of_other_detents_and_gears_are_those_typed_by_hand(orders):
    """Truth: `hand_typed`; periods that are no part of the electrical one, none at all, a gear that reverses."""
    for mode in MODES:
        assert_kernel_agrees("paper", mode, orders, -50.0)


def assert_kernel_agrees(housing, mode, orders, ratio):
    for seed in SEEDS:
        m, x, z, u, q = case(housing, seed, orders, ratio)
        names = list(map(str, m.plant.estimable))
        point = evaluated(m, x, z, u, MODES[mode], indices(m, names))
        dx, dz, y = right_hand_side(x, z, u, mode, q, housing, orders)
        derivatives = differentiated(x, z, u, mode, q, housing, orders, names)
        np.testing.assert_allclose(point.rates, dx, rtol=1e-11)
        np.testing.assert_allclose(point.y, y, rtol=1e-11)
        assert_close(point.rates_by, derivatives[: len(x)])
        assert_close(point.y_by, derivatives[-1])
        flow = np.concatenate([dx, dz])
        assert point.y_dot == pytest.approx(derivatives[-1, : len(flow)] @ flow, rel=1e-9)


@pytest.mark.parametrize("orders", DETENTS, ids=str)
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("housing", HOUSINGS)
def test_the_twin_s_equations_are_those_typed_by_hand(housing, mode, orders):
    """Truth: `hand_typed`; also a gear that reverses, and detents whose period is no part of the electrical one."""
    for seed in SEEDS:
        m, x, z, u, q = case(housing, seed, orders, ratio=(-1) ** seed * 50.0)
        names = [n for n in map(str, m.plant.parameters) if n != "p"]  # by hand the periods follow the poles
        equations = equations_of(m.plant)
        at = ([*x, *z], u, equations.mode_symbols([MODES[mode]]), m.kernel_values())
        dx, dz, y = right_hand_side(x, z, u, mode, q, housing, orders)
        derivatives = differentiated(x, z, u, mode, q, housing, orders, names)
        n, columns = len(x) + len(z), list(indices(m, names))
        np.testing.assert_allclose(equations.rates(*at), np.concatenate([dx, dz]), rtol=1e-11)
        np.testing.assert_allclose(equations.outputs(*at), [y], rtol=1e-11)
        assert_close(equations.rates.by_state(*at), derivatives[:-1, :n])
        assert_close(equations.rates.by_parameter(*at)[:, columns], derivatives[:-1, n:])
        assert_close(equations.outputs.by_state(*at), derivatives[-1, :n])
        assert_close(equations.outputs.by_parameter(*at)[:, columns], derivatives[-1, n:])


def test_the_stuck_rotor_s_margins_are_those_of_set_valued_friction():
    """Truth: the paper's friction: stuck while |T_mot - T_rg| <= T_frs; sliding ends where omega is zero."""
    for seed in SEEDS:
        m, x, z, u, q = case("paper", seed)
        stuck, forward, backward = equations_of(m.plant).margins[0]
        at = ([*x, *z], u, [0.0, 0.0], m.kernel_values())
        drive = motor_torque(x, q, (4, 2)) - gear_torque(x, q)
        np.testing.assert_allclose(stuck(*at), [q["T_frs"] - drive, q["T_frs"] + drive], rtol=1e-11)
        assert forward(*at) == [x[3]]
        assert backward(*at) == [-x[3]]


@pytest.mark.parametrize("start_angle_deg", [0.0, 45.0, 200.0])
def test_a_record_starts_at_rest_with_currents_settled_and_the_gear_unwound(start_angle_deg):
    """Truth: docs/blocks, the start: i = u/R, alpha = theta_0/(p/2), alpha_gear = alpha/G; S(0) = di/dR = -u/R^2."""
    m, *_ = case("paper", 0)
    q = dict(zip(map(str, m.plant.parameters), m.kernel_values(), strict=True))
    theta, symbols = np.deg2rad(start_angle_deg), list(map(str, m.plant.parameters))
    e = np.array([-np.cos(theta), np.sin(theta)])
    at = ([theta], e, [0.0, 0.0], m.kernel_values())
    initial = equations_of(m.plant).initial
    settled = q["U"] * e / q["R"]
    np.testing.assert_allclose(initial(*at), [*settled, theta / 50, 0, theta / 50 / 50, 0, 0, 0], rtol=1e-14)
    by_R = initial.by_parameter(*at)[:, symbols.index("R")]
    np.testing.assert_allclose(by_R[:2], -settled / q["R"], rtol=1e-14)
    assert not by_R[2:].any()
