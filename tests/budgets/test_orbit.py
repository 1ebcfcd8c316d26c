"""Motions that repeat: the period map's derivative, multipliers, sub-harmonics, and several motions at one rate."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.budgets.attractors import steady_states
from mechid.budgets.flying_mechanism import on_modes
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.orbit import find_orbit
from mechid.budgets.orders import phasors
from mechid.budgets.period_map import PeriodMap
from mechid.budgets.steady_state import steady_state
from mechid.command import Command, RateProfile
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from mechid.structure import Modes

FULL = Command(stepping="full", microsteps=1, rate=RateProfile.constant(1.0), start_angle_deg=45.0)
MICRO = replace(FULL, stepping="micro", microsteps=16, start_angle_deg=0.0)
SUBSTEPS = 4


def mode(command, *rates, settle_s=1.0):
    return OperatingMode(name="m", command=command, rates=np.array(rates), settle_s=settle_s)


def period_map(flying, command, rate, names=(), **values):
    mechanism = flying.mechanism.with_values({name.replace("__", "."): value for name, value in values.items()})
    return PeriodMap(mechanism, mode(command, rate), rate, tuple(names), SUBSTEPS)


def test_the_fixed_points_derivative_is_that_of_differences(flying):
    """Truth: fixed points found anew at values a thousandth of each apart."""
    period = period_map(flying, FULL, 37.3, flying.names)
    orbit = find_orbit(period, period.state_after(None, 20))
    size = period(orbit.x).size
    for k, name in enumerate(flying.names):
        value = period.mechanism.value(name)
        ends = []
        for moved in (1.001 * value, 0.999 * value):
            other = replace(period, mechanism=period.mechanism.with_values({name: moved}), names=())
            ends.append(find_orbit(other, orbit.x).x)
        expected = (ends[0] - ends[1]) / (0.002 * value)
        off = np.abs(orbit.by_parameter[:, k] - expected) / size
        assert off.max() < 0.02 * np.abs(expected / size).max() + 1e-9 / value, name


@pytest.mark.parametrize("command", [FULL, MICRO])
def test_transients_decay_as_the_gear_damps_the_load(flying, command):
    """Truth: the load on its gear, held by the rotor, decays with 2 J_m/D; the rotor's give is a few per cent of it."""
    state = steady_state(flying.mechanism, mode(command, 60.0), 60.0, (), SUBSTEPS)
    expected = 2.0 * flying.mechanism.value("load.inertia") / flying.mechanism.value("gear.damping")
    assert state.decay_s == pytest.approx(expected, rel=0.05)


def test_shooting_finds_what_settles_slowly(flying):
    """Truth: the same mechanism simulated for 40 s. The load is damped so weakly that after 1 s a part is left."""
    mechanism = flying.mechanism.with_values({"gear.damping": 0.01})
    short = steady_state(mechanism, mode(MICRO, 30.0), 30.0, (), SUBSTEPS)
    period = PeriodMap(mechanism, mode(MICRO, 30.0), 30.0, (), SUBSTEPS)
    left, gone = period.state_after(None, 15), period.state_after(None, 600)
    assert short.decay_s > 0.5
    assert np.max(np.abs(period.modulo(left - short.x)) / short.size) > 1e-3
    np.testing.assert_allclose(period.modulo(gone - short.x) / short.size, 0.0, atol=1e-6)


@pytest.mark.slow
def test_on_a_free_base_with_a_mode_that_rings(flying):
    """Truth: a free rigid body drifts on, nothing depends on where it is; the mode decays with 1/(zeta w).

    The lines are those of the last half second of twelve simulated ones.
    """
    modes = Modes(np.array([0.0, 35.0]), np.array([0.0, 0.005]), np.array([0.1, 0.5]), np.array([[0.1, 0.05]]))
    mechanism = on_modes(flying.mechanism, modes)
    state = steady_state(mechanism, mode(MICRO, 37.3), 37.3, (), SUBSTEPS)
    assert state.periods == 1
    assert state.multipliers.size == len(mechanism.plant.states) - 2
    assert state.decay_s == pytest.approx(1.0 / (2.0 * np.pi * 35.0 * 0.005), rel=0.2)
    torque = long_run(mechanism, replace(MICRO, rate=RateProfile.constant(37.3)), 12.0)[-10_000:]
    expected = np.abs(phasors(torque, 20_000.0, state.frequency_hz))
    np.testing.assert_allclose(np.abs(state.lines), expected, atol=1e-3 * expected.max())


DOUBLED = {
    "stepper.detent.1.amplitude": 0.0693,
    "friction.static": 0.05,
    "friction.coulomb": 0.0065,
    "friction.viscous": 0.00122,
}
STICKY = {"friction.static": 0.03, "friction.viscous": 0.002}


def long_run(mechanism, command, seconds):
    """Return the torque at 20 kHz."""
    simulator = Simulator(mechanism.plant, command, TimeBase(20_000.0, round(seconds * 20_000)))
    return simulate_run(simulator.run(mechanism.kernel_values(), substeps=2)).torque


def test_a_motion_of_two_periods_has_lines_between(flying):
    """Truth: least squares over the last two of eight simulated seconds: a quarter of the rate is its fundamental."""
    mechanism = flying.mechanism.with_values(DOUBLED)
    state = steady_state(mechanism, mode(MICRO, 21.1), 21.1, (), SUBSTEPS)
    torque = long_run(mechanism, replace(MICRO, rate=RateProfile.constant(21.1)), 8.0)[120_000:]
    expected = np.abs(phasors(torque, 20_000.0, state.frequency_hz))
    assert (state.periods, state.fundamental_hz) == (2, 21.1 / 4.0)
    assert abs(state.lines[::2]).max() > 0.01 * abs(state.lines).max()
    np.testing.assert_allclose(np.abs(state.lines), expected, atol=5e-3 * expected.max())


@pytest.fixture(scope="module")
def sticky(flying):
    """Return the steady states of a mechanism with much stiction and little viscous friction, from 18 to 36 steps/s."""
    return steady_states(flying.mechanism.with_values(STICKY), mode(MICRO, *np.arange(18.0, 37.0, 3.0)), (), 1)


@pytest.mark.parametrize(
    ("way", "profile"),
    [
        ("from rest", ((0.0, 21.0), (12.0, 21.0))),
        ("falling", ((0.0, 0.0), (2.0, 60.0), (8.0, 21.0), (12.0, 21.0))),
    ],
)
def test_a_rate_reached_from_rest_and_from_above(flying, sticky, way, profile):
    """Truth: long simulations at 20 kHz, started at the rate, and run up beyond it and slowly down to it."""
    known = {state.reached[0]: state for state in sticky[1]}
    command = replace(MICRO, rate=RateProfile.through(profile))
    torque = long_run(flying.mechanism.with_values(STICKY), command, 12.0)[200_000:]
    assert set(known) == {"from rest", "falling"}
    assert known["from rest"].rms > 5.0 * known["falling"].rms
    assert known[way].rms == pytest.approx(torque.std(), rel=0.05)


@pytest.mark.parametrize(("rate", "follows"), [(60.0, True), (2500.0, False)])
def test_a_rotor_that_does_not_follow(flying, rate, follows):
    """Truth: by how many times 3.6 deg, two steps, it is behind the command after a thousand of these."""
    state = steady_state(flying.mechanism, mode(FULL, rate), rate, (), SUBSTEPS)
    period = PeriodMap(flying.mechanism, mode(FULL, rate), rate, (), SUBSTEPS)
    behind = -period.state_after(None, 1000)[2] / np.radians(3.6)
    assert state.follows is follows
    assert bool(behind < 2.0) is follows


def test_a_clock_with_a_tick_makes_it_aperiodic(flying):
    """Truth: lines without the tick, which is a thousandth of a microstep's time here: they hardly differ."""
    rates = mode(MICRO, 45.0, 46.0)
    ticking = replace(rates, command=replace(MICRO, clock_tick_s=1.3e-6))
    found = steady_states(flying.mechanism, ticking, (), 1)
    for (state,), (plain, *_) in zip(found, steady_states(flying.mechanism, rates, (), 1), strict=True):
        assert (state.periods, state.multipliers.size, state.reached) == (0, 0, ("from rest",))
        np.testing.assert_allclose(state.lines, plain.lines, atol=0.01 * np.abs(plain.lines).max())


def test_one_motion_is_one_however_it_is_reached(flying):
    """Truth: the paper's mechanism, run at each rate from rest, from the next lower and the next higher one."""
    (first,), (middle,), (last,) = steady_states(flying.mechanism, mode(MICRO, 45.0, 46.0, 47.0), ("load.inertia",), 1)
    assert set(middle.reached) == {"from rest", "rising", "falling"}
    assert (set(first.reached), set(last.reached)) == ({"from rest", "falling"}, {"from rest", "rising"})
    assert middle.gradient.shape == (middle.lines.size, 1)
