"""Step edges against closed forms, an exact rational twin, and a brute-force integration."""

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from mechid.command import RateProfile
from mechid.command.edges import running_sum, step_edges, time_to_travel
from mechid.errors import UsageError


def exact_segments(points, duration):
    """Return (start, end, start rate, end rate) of a profile on [0, duration], in exact fractions."""
    first, last = points[0], points[-1]
    held = [(min(Fraction(0), first[0]), first[1]), *points, (max(duration, last[0]), last[1])]
    for (t0, r0), (t1, r1) in pairwise(held):
        start, end = max(t0, Fraction(0)), min(t1, duration)
        if start < end:
            slope = (r1 - r0) / (t1 - t0)
            yield start, end, r0 + slope * (start - t0), r0 + slope * (end - t0)


def exact_position(points, t):
    """Return the integral of the rate from 0 to t in full steps, in exact fractions."""
    return sum((end - start) * (r0 + r1) / 2 for start, end, r0, r1 in exact_segments(points, t))


def exact_indices(points, n, duration):
    """Return the sequence of step indices, walked from one turning point to the next."""
    index, position, sequence = 0, Fraction(0), []
    for start, end, r0, r1 in exact_segments(points, duration):
        turn = (end - start) * r0 / (r0 - r1) if r0 * r1 < 0 else end - start
        for travel in (turn * (r0 + (0 if r0 * r1 < 0 else r1)) / 2, (end - start - turn) * r1 / 2):
            position += n * travel
            while position >= index + 1:
                index += 1
                sequence.append(index)
            while position <= index - 1:
                index -= 1
                sequence.append(index)
    return sequence


decimal = st.integers(-400, 400).map(lambda tenths: Fraction(tenths, 10))


@st.composite
def decimal_profiles(draw):
    """Draw breakpoints with decimal times and rates, some of them jumps; as fractions."""
    gaps = draw(st.lists(st.integers(0, 30), min_size=0, max_size=6))
    times = [Fraction(draw(st.integers(-10, 20)), 10)]
    for gap in gaps:
        jumped = len(times) > 1 and times[-1] == times[-2]
        times.append(times[-1] + Fraction(max(gap, 1) if jumped else gap, 10))
    return [(time, draw(decimal)) for time in times]


def as_floats(points):
    return RateProfile.through((float(time), float(rate)) for time, rate in points)


EDGE_AT_THE_END = {
    "points": [(Fraction(-1, 10), Fraction(-189, 5)), (Fraction(23, 10), Fraction(-141, 5))],
    "n": 2,
    "tenths": 106,
}
"""The integral reaches a step at the last instant exactly, and a hair later in rounded arithmetic."""


@example(**EDGE_AT_THE_END)
@given(points=decimal_profiles(), n=st.sampled_from([1, 2, 3, 16]), tenths=st.integers(1, 120))
@settings(derandomize=True, database=None, deadline=None, max_examples=400)
def test_indices_are_those_of_exact_arithmetic(points, n, tenths):
    """Truth: the rule of the step index, walked in fractions of the decimals as they are written."""
    duration = Fraction(tenths, 10)
    _, index = step_edges(as_floats(points), n, float(duration))
    assert index.tolist() == exact_indices(points, n, duration)


@given(
    start=st.floats(-2.0, 2.0),
    gaps=st.lists(st.one_of(st.just(0.0), st.floats(1e-3, 5.0)), max_size=5),
    data=st.data(),
    n=st.integers(1, 64),
)
@settings(derandomize=True, database=None, deadline=None, max_examples=400)
def test_each_edge_is_where_the_integral_reaches_its_step(start, gaps, data, n):
    """Truth: the exact integral up to the edge's instant is k/n, and k moves by one at a time."""
    times = [start]
    for gap in gaps:
        jumped = len(times) > 1 and times[-1] == times[-2]
        times.append(times[-1] + (1.0 if jumped and gap == 0.0 else gap))
    rates = data.draw(st.lists(st.floats(-120.0, 120.0), min_size=len(times), max_size=len(times)))
    points = [(Fraction(time), Fraction(rate)) for time, rate in zip(times, rates, strict=True)]
    edges, index = step_edges(as_floats(points), n, 10.0)
    assert np.all(np.abs(np.diff(index, prepend=0)) == 1)
    assert np.all(np.diff(edges, prepend=0.0) > 0.0)
    assert np.all(edges <= 10.0)
    peak = max(abs(rate) for rate in rates)
    for edge, k in list(zip(edges.tolist(), index.tolist(), strict=True))[:: max(1, edges.size // 20)]:
        missed = exact_position(points, Fraction(edge)) - Fraction(k, n)
        assert abs(float(missed)) <= 1e-12 * peak * edge


@pytest.mark.parametrize("rate", [46.0, -46.0, 0.37, 1.1, 119.9])
@pytest.mark.parametrize("n", [1, 2, 16])
def test_constant_rate(rate, n):
    """Truth: step k comes at k/(n |r|), the last one at the very end included."""
    duration = 250 / (n * abs(rate))
    times, index = step_edges(RateProfile.constant(rate), n, duration)
    k = np.arange(1, 251)
    np.testing.assert_array_equal(index, k * np.sign(rate))
    np.testing.assert_allclose(times, k / (n * abs(rate)), rtol=4e-16, atol=0.0)


def test_sweep_of_a_minute():
    """Truth: r = c t gives t = sqrt(2 k/(n c)), 57600 edges, to rounding."""
    times, index = step_edges(RateProfile.through([(0.0, 0.0), (60.0, 120.0)]), 16, 60.0)
    k = np.arange(1, 57601)
    np.testing.assert_array_equal(index, k)
    np.testing.assert_allclose(times, np.sqrt(k / 16), rtol=5e-16, atol=0.0)


def test_falling_sweep_is_the_rising_one_mirrored():
    """Truth: run backwards in time, r = 120 - 2 t is the rising sweep; its last edge is where it stops."""
    times, index = step_edges(RateProfile.through([(0.0, 120.0), (60.0, 0.0)]), 16, 70.0)
    left = (57600 - index) / 16
    np.testing.assert_array_equal(index, np.arange(1, 57601))
    np.testing.assert_allclose(times, 60.0 - np.sqrt(left), rtol=0.0, atol=1.5e-14)
    assert times[-1] == 60.0


def test_first_edges_of_a_falling_sweep_do_not_cancel():
    """Truth: k/n = 120 t - t^2 to 1e-12 of k/n, from the first microstep on."""
    times, index = step_edges(RateProfile.through([(0.0, 120.0), (60.0, 0.0)]), 16, 60.0)
    reached = [float(Fraction(t) * (120 - Fraction(t)) * 16) for t in times.tolist()]
    np.testing.assert_allclose(reached, index, rtol=1e-12, atol=0.0)


def test_nearly_constant_rate_keeps_its_digits():
    """Truth: a rate that changes by 1e-12 of itself has the edges of a constant one to as many digits."""
    times, _ = step_edges(RateProfile.through([(0.0, 46.0), (10.0, 46.0 * (1 + 1e-12))]), 16, 10.0)
    k = np.arange(1, times.size + 1)
    assert times.size == 7360
    np.testing.assert_allclose(times, k / (16 * 46.0), rtol=2e-12, atol=0.0)


def test_dwell_and_reversal_against_brute_force():
    """Truth: the rate summed on a grid of 10 us, the index moved step by step."""
    points = [
        (0.2, 7.0),
        (0.5, 30.0),
        (0.9, 30.0),
        (0.9, 0.0),
        (1.3, 0.0),
        (1.3, -11.0),
        (2.4, -3.5),
        (2.9, 19.0),
    ]
    n, dt, duration = 4, 1e-5, 3.49
    middle = (np.arange(round(duration / dt)) + 0.5) * dt
    before = np.searchsorted([time for time, _ in points], middle, side="right")
    rate = np.empty_like(middle)
    for at in range(len(points) + 1):
        (t0, r0), (t1, r1) = points[max(at - 1, 0)], points[min(at, len(points) - 1)]
        inside = before == at
        rate[inside] = r0 if t1 <= t0 else r0 + (r1 - r0) * (middle[inside] - t0) / (t1 - t0)
    expected, held = [], 0
    for end, position in zip((middle + dt / 2).tolist(), np.cumsum(n * rate * dt).tolist(), strict=True):
        if abs(position - held) >= 1.0:
            held += round(math.copysign(1, position - held))
            expected.append((end, held))
    times, index = step_edges(RateProfile.through(points), n, duration)
    assert index.tolist() == [held for _, held in expected]
    assert {-1, 1} == set(np.sign(np.diff(index)).tolist())
    np.testing.assert_allclose(times, [end for end, _ in expected], rtol=0.0, atol=1.01 * dt)


def test_swinging_about_a_step_does_not_chatter():
    """Truth: after 1.5 steps the command swings between 0.5 and 1.5; the index stays 1."""
    swing = [(0.15, 10.0)]
    for turn in range(20):
        end = 0.15 + 0.1 * (turn + 1)
        sign = -1.0 if turn % 2 == 0 else 1.0
        swing += [(swing[-1][0], 10.0 * sign), (end, 10.0 * sign)]
    times, index = step_edges(RateProfile.through(swing), 1, 2.1)
    assert index.tolist() == [1]
    np.testing.assert_allclose(times, [0.1], rtol=1e-15)


def test_reversal_between_steps_goes_on_to_the_step_below():
    """Truth: up 2.5 steps at 10/s, then down: 1, 2 on the way up, then 1, 0, -1, none at 2 again."""
    times, index = step_edges(RateProfile.through([(0.25, 10.0), (0.25, -10.0)]), 1, 0.6)
    assert index.tolist() == [1, 2, 1, 0, -1]
    np.testing.assert_allclose(times, [0.1, 0.2, 0.4, 0.5, 0.6], rtol=1e-14)


def test_touching_a_step_at_a_smooth_reversal_reaches_it():
    """Truth: r = 4 - 4 t peaks at 2 steps at t = 1; t = 1 - sqrt(1 - k/2) up, 1 + sqrt(1 - k/2) down."""
    profile = RateProfile.through([(0.0, 4.0), (2.0, -4.0)])
    times, index = step_edges(profile, 1, 2.0)
    assert index.tolist() == [1, 2, 1, 0]
    np.testing.assert_allclose(times, [1 - math.sqrt(0.5), 1.0, 1 + math.sqrt(0.5), 2.0], rtol=4e-16)


def test_up_and_down_returns_mirrored():
    """Truth: a ramp mirrored about its turn; the edge for k up and the next for k down are mirrored."""
    times, index = step_edges(RateProfile.through([(0.0, 80.0), (10.0, -80.0)]), 16, 10.0)
    top = int(index.max())
    assert top == 3200
    up, down = times[: top - 1], times[top:-1]
    np.testing.assert_array_equal(index[: top - 1], index[top:-1][::-1])
    np.testing.assert_allclose(5.0 - up, (down - 5.0)[::-1], rtol=0.0, atol=2e-15)


@pytest.mark.parametrize("ramp", [0.1, 0.3, 0.7])
@pytest.mark.parametrize("dwell", [0.1, 1.3])
def test_moves_that_stop_on_a_step_make_each_step(ramp, dwell):
    """Truth: 50 moves of ramp * 90 steps each, in decimals that floats round, end on the last step."""
    points, now = [(0.0, 0.0)], 0.0
    for _ in range(50):
        for lapse, rate in ((ramp, 90.0), (ramp, 0.0), (dwell, 0.0)):
            now = round(now + lapse, 10)
            points.append((now, rate))
    _, index = step_edges(RateProfile.through(points), 1, now)
    np.testing.assert_array_equal(index, np.arange(1, round(50 * ramp * 90) + 1))


def test_a_rate_table_with_many_rows_keeps_its_digits():
    """Truth: 200 000 rows of a constant 46 steps/s with a rounded time column are that constant."""
    rows = [(round(0.0003 * at, 4), 46.0) for at in range(200_001)]
    times, index = step_edges(RateProfile.through(rows), 16, 60.0)
    k = np.arange(1, 46 * 60 * 16 + 1)
    np.testing.assert_array_equal(index, k)
    np.testing.assert_allclose(times, k / (16 * 46.0), rtol=1e-15, atol=1e-16)


@pytest.mark.parametrize(
    "points", [[(-3.0, 5.0), (-1.0, 40.0)], [(0.0, 40.0)], [(2.0, 40.0)], [(0.0, 1.0), (0.0, 40.0)]]
)
def test_the_nearest_rate_holds_outside_the_profile(points):
    """Truth: from t = 0 on, each of these is 40 steps/s."""
    times, index = step_edges(RateProfile.through(points), 1, 1.0)
    np.testing.assert_array_equal(index, np.arange(1, 41))
    np.testing.assert_allclose(times, np.arange(1, 41) / 40.0, rtol=1e-15)


def test_what_a_profile_says_before_zero_is_not_integrated():
    """Truth: r = 10 + 10 t from t = -1; from 0 on t = sqrt(1 + k/5) - 1."""
    times, index = step_edges(RateProfile.through([(-1.0, 0.0), (4.0, 50.0)]), 1, 4.0)
    np.testing.assert_array_equal(index, np.arange(1, 121))
    np.testing.assert_allclose(times, np.sqrt(1.0 + index / 5.0) - 1.0, rtol=4e-15)


def test_a_longer_record_only_adds_edges():
    """Truth: causality, bit for bit."""
    profile = RateProfile.through([(0.0, 5.0), (3.3, 61.0), (5.1, -80.0), (9.7, 12.0)])
    whole, _ = step_edges(profile, 16, 12.0)
    for duration in (1.234, 3.3, 4.0, 9.7, 11.0):
        part, _ = step_edges(profile, 16, duration)
        np.testing.assert_array_equal(part, whole[whole <= duration])


@pytest.mark.parametrize(("rate", "duration"), [(0.0, 10.0), (0.9, 1.0), (46.0, 0.0)])
def test_no_edges(rate, duration):
    """Truth: a dwell, less than one step, and no time at all."""
    times, index = step_edges(RateProfile.constant(rate), 1, duration)
    assert times.shape == index.shape == (0,)


@pytest.mark.parametrize("rate", [1e9, 1e300, 1.7e308])
def test_too_many_edges_are_refused(rate):
    with pytest.raises(UsageError, match=r"steps in 60\.0 s, more than 20000000; check the rate"):
        step_edges(RateProfile.constant(rate), 16, 60.0)


def test_running_sum_is_exact_to_rounding():
    """Truth: math.fsum of every prefix, over terms of 12 decades that cancel."""
    generator = np.random.default_rng(7)
    terms = generator.normal(size=3000) * 10.0 ** generator.uniform(-6, 6, size=3000)
    exact = [math.fsum(terms[: at + 1]) for at in range(terms.size)]
    np.testing.assert_allclose(running_sum(terms), exact, rtol=1e-15, atol=1e-13)
    assert np.max(np.abs(np.cumsum(terms) - exact)) > 1e-10


@given(speed=st.floats(0.0, 1e3), acceleration=st.floats(0.0, 1e3), time=st.floats(1e-6, 1e3))
@settings(derandomize=True, database=None, deadline=None)
def test_time_to_travel_inverts_the_distance(speed, acceleration, time):
    """Truth: d = v t + a t^2 / 2."""
    distance = speed * time + acceleration * time**2 / 2
    assume(distance > 1e-12)
    found = time_to_travel(np.array([distance]), np.array([speed]), np.array([acceleration]))
    np.testing.assert_allclose(found, [time], rtol=2e-15)
