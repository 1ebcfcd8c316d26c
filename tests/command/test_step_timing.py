"""Timing of steps and shaped rates. Truth: the closed form of a mode, a simulation by the kernel."""

import math
import re

import numpy as np
import pytest

import mechid
from mechid.errors import UsageError
from stiff_motor import pair_over_step, pair_over_step_in_closed_form


@pytest.mark.parametrize("damping", [0.02, 0.1])
def test_a_pair_leaves_the_swing_of_the_closed_form(damping):
    """Truth: 1 - exp(-pi zeta/sqrt(1 - zeta^2)) of the swing that one step leaves, to 1 %, by the kernel."""
    assert pair_over_step(damping) == pytest.approx(pair_over_step_in_closed_form(damping), rel=0.01)


def test_pairs_are_half_a_damped_period_apart():
    times = mechid.paired_steps(30, 3.0, 10.0, 0.3)
    np.testing.assert_allclose(times[::2], np.arange(1, 31) / 3.0)
    np.testing.assert_allclose(times[1::2] - times[::2], 0.05 / math.sqrt(1.0 - 0.09))


def test_staggered_steps_suppress_the_line_of_their_formula():
    """Truth: the discrete sum over the pulses: the order 1 of the rate vanishes with a delay of half an interval."""
    times = mechid.staggered_steps(200, 50.0, (0.0, 0.01))
    line = [abs(np.exp(-2j * np.pi * f * times).mean()) for f in (50.0, 25.0, 100.0)]
    assert line == pytest.approx([0.0, math.cos(math.pi / 4.0), 1.0], abs=1e-9)
    even = np.exp(-2j * np.pi * 50.0 * mechid.staggered_steps(200, 50.0, (0.0,)))
    assert abs(even.mean()) == pytest.approx(1.0)


def residual_swing(rate, frequency_hz, damping):
    """Return the swing that a rate leaves in a mode, relative to that of one jump by 1 full step/s at its end.

    The closed form for piecewise linear rates: |sum of the jumps and slopes over exp((zeta w + j w_d)(t - end))|.
    """
    omega = 2.0 * math.pi * frequency_hz
    s, t = omega * complex(damping, math.sqrt(1.0 - damping**2)), rate[:, 0] - rate[-1, 0]
    total = 0.0
    for k, (lapse, change) in enumerate(zip(np.diff(t), np.diff(rate[:, 1]), strict=True)):
        total += (
            change * np.exp(s * t[k]) if lapse == 0.0 else change / lapse * np.diff(np.exp(s * t[k : k + 2]))[0] / s
        )
    return abs(total)


ROUND_TRIP = np.array([[0.0, 0.0], [0.0, 30.0], [0.4, 40.0], [0.9, 40.0], [0.93, -20.0], [1.7, -20.0], [1.7, 0.0]])


@pytest.mark.parametrize("robust", [False, True])
@pytest.mark.parametrize("damping", [0.0, 0.05, 0.4])
def test_shaped_rates_leave_no_swing(damping, robust):
    """Truth: the closed form of the mode's response; the rates at both ends and the travel stay."""
    shaped = mechid.shaped_rate(ROUND_TRIP, 7.0, damping, robust=robust)
    assert residual_swing(ROUND_TRIP, 7.0, damping) > 1.0
    assert residual_swing(shaped, 7.0, damping) < 1e-9
    assert (shaped[0, 1], shaped[-1, 1]) == pytest.approx((0.0, 0.0), abs=1e-12)
    travel = [np.trapezoid(r[:, 1], r[:, 0]) for r in (ROUND_TRIP, shaped)]
    assert travel[1] == pytest.approx(travel[0], rel=1e-12)


def test_a_robust_shape_bears_an_error_of_the_frequency():
    """Truth: the residual of two impulses is pi/2 times the relative error, that of three its square."""
    left = [residual_swing(mechid.shaped_rate(1.0, 10.0, robust=robust), 10.5, 0.0) for robust in (False, True)]
    assert left == pytest.approx([math.sin(0.05 * math.pi / 2.0), math.sin(0.05 * math.pi / 2.0) ** 2], rel=1e-9)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_ramp_keeps_its_limits_and_passes_as_asked(way):
    """Truth: differences of the profile: accelerations, jerk, and the slope at the rate to be passed."""
    ramp = mechid.shaped_ramp(way * 2.0, way * 60.0, 20.0, 400.0, [(way * 46.0, 80.0, 2.0)])
    assert ramp[[0, -1], 1] == pytest.approx([way * 2.0, way * 60.0], abs=1e-12)
    time, rate = ramp[:, 0], way * ramp[:, 1]
    slope = np.diff(rate) / np.diff(time)
    inside = (rate[:-1] >= 44.0 - 1e-9) & (rate[1:] <= 48.0 + 1e-9)
    assert slope[inside] == pytest.approx([80.0])
    assert slope.max() == pytest.approx(80.0)
    assert 20.0 in slope.round(9)
    jerk = np.diff(slope) / (0.5 * (time[2:] - time[:-2]))
    assert np.abs(jerk).max() <= 400.0 * (1.0 + 1e-9)
    assert mechid.make_command("full", rate=ramp).rate.at(99.0) == pytest.approx(way * 60.0)


def test_a_short_ramp_turns_before_it_reaches_its_acceleration():
    """Truth: a triangle of the acceleration gains peak^2/jerk."""
    ramp = mechid.shaped_ramp(0.0, 1.0, 20.0, 100.0)
    assert ramp[-1, 0] == pytest.approx(2.0 * math.sqrt(1.0 / 100.0))
    assert mechid.shaped_ramp(5.0, 5.0, 20.0, 100.0).tolist() == [[0.0, 5.0]]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: mechid.paired_steps(3, 10.0, 4.0),
            "rate: found 10 pairs/s; half a period of the mode takes 0.125 s",
        ),
        (lambda: mechid.paired_steps(3, -1.0, 4.0), "rate: found -1.0; write a number above 0"),
        (lambda: mechid.paired_steps(0, 1.0, 4.0), "steps: found 0; write a whole number from 1"),
        (lambda: mechid.paired_steps(1, 1.0, 4.0, 1.0), "damping: found 1.0; write a damping ratio from 0 to below 1"),
        (lambda: mechid.staggered_steps(3, 10.0, (0.0, 0.1)), "delays_s: step 2 at 0.4 s is not after the one before"),
        (lambda: mechid.staggered_steps(3, 10.0, ()), "delays_s: found (); write one finite delay"),
        (lambda: mechid.shaped_rate([1.0, 2.0], 4.0), "rate: found an array of shape (2,); write a rate, or [[time"),
        (lambda: mechid.shaped_rate(1.0, 0.0), "frequency_hz: found 0.0; write a number above 0"),
        (lambda: mechid.shaped_ramp(0.0, math.nan, 1.0, 1.0), "end_rate: found nan; write full steps/s"),
        (
            lambda: mechid.shaped_ramp(0.0, 9.0, 1.0, 1.0, [(5.0, 1.0)]),
            "crossings[0]: found (5.0, 1.0); write",
        ),
        (
            lambda: mechid.shaped_ramp(0.0, 9.0, 1.0, 1.0, [(9.0, 1.0, 1.0)]),
            "crossings[0]: found (9.0, 1.0, 1.0); write a b",
        ),
        (
            lambda: mechid.shaped_ramp(0.0, 60.0, 20.0, 100.0, [(46.0, 80.0, 2.0)]),
            "jerk: found 100; from 48 to 60",
        ),
        (
            lambda: mechid.shaped_ramp(0.0, 60.0, 9.0, 900.0, [(20.0, 8.0, 5.0), (26.0, 8.0, 5.0)]),
            "jerk: found 900; from 25",
        ),
    ],
)
def test_refusals(call, message):
    with pytest.raises(UsageError, match="^" + re.escape(message)):
        call()
