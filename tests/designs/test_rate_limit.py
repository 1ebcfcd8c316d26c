"""Ranges of rates that hold: against closed forms, and against a motor driven at rate after rate."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from layouts import SINGLE_STEPPER, changed
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.command import RateProfile
from mechid.designs.rate_limit import rate_limit, rates_to_try
from mechid.designs.settings import RATE
from mechid.designs.step_loss import drive, pull_in, pull_out
from mechid.simulation.resonances import free_resonances
from paper import constant

FULL = constant(0.0, start_angle_deg=45.0)
GRID = np.geomspace(RATE.lowest, RATE.highest, 400).tolist()
HOLE = [(120.0, 150.0)]


def small_stepper(**stepper):
    """Return a synthetic motor without gear, lightly damped, of the size of a real one."""
    values = {"peak_current": 1.0, "torque_constant": 0.05, "rotor_inertia": 2.4e-6, **stepper}
    values.setdefault("detent", [{"period_deg": 1.8, "amplitude": 0.00125, "phase_deg": 0.0}])
    friction = {"static": 0.0025, "coulomb": 0.0025, "viscous": 1.43e-4}
    table = {"assembly": "current_driven_stepper", **changed(SINGLE_STEPPER, {"stepper": values, "friction": friction})}
    return mechanism_from_table(table, "a small stepper")


def at_once(mechanism, rate):
    """Tell whether a motor starts at a rate at once and stops at once without losing a step."""
    return not drive(mechanism, replace(FULL, rate=RateProfile.constant(rate)), RATE.started_s, torque=False).lost


def slowly(mechanism, begin, rate):
    """Tell whether a motor follows from one rate to another and back within a second each."""
    times = np.cumsum([0.0, RATE.ramp_s, RATE.started_s, RATE.ramp_s])
    profile = RateProfile.through(list(zip(times, (begin, rate, rate, begin), strict=True)))
    return not drive(mechanism, replace(FULL, rate=profile), float(times[-1]), torque=False).lost


@pytest.mark.parametrize(
    ("holds", "ranges", "holes", "rate", "limit"),
    [
        (lambda r: r < 300.0, [(RATE.lowest, 300.0)], [], 300.0, 300.0),
        (
            lambda r: r < 120.0 or 150.0 < r < 1100.0,
            [(RATE.lowest, 120.0), (150.0, 1100.0)],
            [(120.0, 150.0)],
            120.0,
            1100.0,
        ),
        (lambda r: r < 120.0 or r > 150.0, [(RATE.lowest, 120.0), (150.0, RATE.highest)], HOLE, 120.0, None),
        (lambda r: 50.0 < r < 90.0, [(50.0, 90.0)], [(RATE.lowest, 50.0)], 0.0, 90.0),
        (lambda r: True, [(RATE.lowest, RATE.highest)], [], None, None),
        (lambda r: False, [], [], 0.0, 0.0),
        (lambda r: r < 120.0 or r == GRID[250], [(RATE.lowest, 120.0)], [], 120.0, 120.0),
    ],
)
def test_ranges_end_where_holding_ends(holds, ranges, holes, rate, limit):
    """Truth: by construction, to half a percent; a rate that holds all by itself is none that one can start at."""
    found = rate_limit(holds, GRID)
    for mine, true in ((found.ranges, ranges), (found.holes, holes)):
        np.testing.assert_allclose(np.reshape(mine, (-1, 2)), np.reshape(true, (-1, 2)), rtol=RATE.resolution)
    assert all(holds(end) for end in itertools.chain(*found.ranges))
    for mine, true in ((found.rate, rate), (found.limit, limit)):
        assert mine is None if true is None else mine == pytest.approx(true, rel=RATE.resolution)
    assert found.holds_again == bool(holes)


@pytest.mark.parametrize("amplitude", [0.0, 0.00125, 0.01])
def test_the_rotor_swings_on_its_motors_torque(amplitude):
    """Truth: closed form. Both coils at I/sqrt(2) pull with p/2 k_m I; the detent, at 45 deg, takes 200 K_D of it."""
    mechanism = small_stepper(detent=[{"period_deg": 1.8, "amplitude": amplitude, "phase_deg": 0.0}])
    stiffness = 50.0 * 0.05 * 1.0 - 200.0 * amplitude
    (found,) = free_resonances(mechanism, FULL)
    assert found.frequency_hz == pytest.approx(math.sqrt(stiffness / 2.4e-6) / (2.0 * math.pi), rel=1e-9)
    assert found.damping == pytest.approx(1.43e-4 / (2.0 * math.sqrt(stiffness * 2.4e-6)), rel=1e-9)


def test_rates_are_tried_closely_around_a_resonance():
    """Truth: the distances that are stated, from a quarter of the resonance to a fifth above it, and beyond."""
    mechanism = small_stepper()
    (found,) = free_resonances(mechanism, FULL)
    rates = np.array(rates_to_try(mechanism, FULL))
    assert (rates[0], rates[-1]) == (RATE.lowest, RATE.highest)
    near = (rates[:-1] >= 0.25 * found.frequency_hz) & (rates[:-1] <= 1.2 * found.frequency_hz)
    most = np.maximum(rates[:-1] * np.where(near, RATE.near - 1.0, RATE.far - 1.0), RATE.least)
    assert near.sum() > 100
    assert np.all(np.diff(rates) <= most * (1.0 + 1e-9))


def test_a_hole_at_a_resonance_and_the_limit_beyond():
    """Truth: brute force, the same motor started at every quarter of a full step/s around its resonance.

    What is narrower than the distance of rates tried may be missed: a twentieth of all may be told wrong, and no
    stretch of 3 % and more.
    """
    mechanism = small_stepper()
    found = pull_in(mechanism, FULL)
    rates = np.arange(90.0, 210.0, 0.25)
    true = np.array([at_once(mechanism, float(r)) for r in rates])
    told = np.array([any(a <= r <= b for a, b in found.ranges) for r in rates])
    assert 0.1 < 1.0 - true.mean() < 0.6
    assert np.mean(true != told) < 0.05
    for wrong, run in itertools.groupby(zip(rates, true != told, strict=True), key=lambda pair: pair[1]):
        stretch = [rate for rate, _ in run]
        assert not wrong or stretch[-1] < 1.03 * stretch[0]
    assert found.limit > 5.0 * found.rate
    assert at_once(mechanism, 0.98 * found.limit)
    assert not any(at_once(mechanism, float(r)) for r in np.geomspace(1.02 * found.limit, RATE.highest, 60))


def test_a_slow_start_begins_above_the_hole():
    """Truth: brute force. From rest the way through the hole loses steps; from above it no rate does."""
    mechanism = small_stepper()
    found = pull_out(mechanism, FULL)
    hole = pull_in(mechanism, FULL).holes[-1]
    assert found.brought_from > hole[1]
    assert (found.limit, found.holes) == (None, ())
    rates = np.geomspace(1000.0, RATE.highest, 12)
    assert all(slowly(mechanism, found.brought_from, float(rate)) for rate in rates)
    assert not all(slowly(mechanism, 0.0, float(rate)) for rate in rates)
