"""What a model follows. Truth: series of which every window's RMS is known."""

import math

import numpy as np
import pytest

from mechid.signal.following import assess_following, first_out_of_step

RATE_HZ = 1000.0
WINDOW = 50
STEP = math.radians(1.8)


def waves(seconds=2.0):
    """Return a sine of 40 Hz, two periods in every window: RMS 1 in each."""
    return math.sqrt(2.0) * np.sin(2.0 * np.pi * 40.0 * np.arange(round(seconds * RATE_HZ)) / RATE_HZ)


def with_window(residual, k, values):
    found = residual.copy()
    found[k * WINDOW : (k + 1) * WINDOW] = values[:WINDOW]
    return found


@pytest.mark.parametrize(("share", "lost"), [(0.49, None), (0.51, 7 * WINDOW)])
def test_half_of_what_is_measured_in_a_window_is_the_limit(share, lost):
    y = waves()
    found = assess_following(y, with_window(np.zeros(y.size), 7, share * y), RATE_HZ)
    assert found.lost == lost
    assert found.worst == pytest.approx(share / 0.5)
    assert found.worst_at == 7 * WINDOW
    assert found.share == (1.0 if lost is None else 39.0 / 40.0)


@pytest.mark.parametrize(("size", "lost"), [(0.12, None), (0.13, 7 * WINDOW)])
def test_where_nothing_moves_an_eighth_of_the_record_is_the_limit(size, lost):
    """In one window of 40 nothing is measured: the record's RMS is sqrt(39/40)."""
    y = with_window(waves(), 7, np.zeros(WINDOW))
    found = assess_following(y, with_window(np.zeros(y.size), 7, size * waves()), RATE_HZ)
    assert found.lost == lost
    assert found.worst == pytest.approx(size / (0.125 * math.sqrt(39.0 / 40.0)))


def test_noise_alone_in_a_quiet_stretch_is_followed_and_an_event_of_its_size_in_a_still_record_is_not():
    """Truth: half of the record is at rest, noise of a fifth of the motion all over; then no noise, but one window."""
    noise = 0.2 * np.random.default_rng(3).standard_normal(2000)
    still = np.concatenate([waves(1.0), np.zeros(1000)])
    assert assess_following(still + noise, noise, RATE_HZ).lost is None
    event = with_window(np.zeros(2000), 30, 0.2 * waves())
    assert assess_following(still + event, event, RATE_HZ).lost == 30 * WINDOW


def test_what_is_declared_as_noise_is_none_of_the_models():
    y = with_window(waves(), 7, np.zeros(WINDOW))
    off = with_window(np.zeros(y.size), 7, 0.29 * waves())
    assert assess_following(y, off, RATE_HZ, noise=0.2, chance=1.0).lost == 7 * WINDOW
    assert assess_following(y, off, RATE_HZ, noise=0.2, chance=2.0).lost is None


def test_a_record_lost_for_most_of_it_is_not_followed_although_it_is_so_throughout():
    y = waves()
    off = np.where(np.arange(y.size) < 400, 0.0, y)
    found = assess_following(y, off, RATE_HZ)
    assert found.lost == 400
    assert found.share == pytest.approx(0.2)


def test_a_simulation_that_fails_is_followed_up_to_there():
    y, off = waves(), np.zeros(2000)
    off[730:] = np.nan
    found = assess_following(y, off, RATE_HZ)
    assert (found.lost, found.worst) == (700, math.inf)


def test_what_is_left_at_the_end_goes_with_the_last_window():
    y = waves()[:1990]
    off = np.zeros(1990)
    off[1960:] = y[1960:]
    assert assess_following(y, off, RATE_HZ).lost == 1900


def test_a_motor_is_in_step_until_it_is_two_full_steps_off():
    """Truth: an encoder's zero of half a turn, a ripple of one step, and a loss of four full steps at 1.2 s."""
    t = np.arange(2000) / RATE_HZ
    residual = math.pi + STEP * np.sin(2.0 * np.pi * 40.0 * t)
    assert first_out_of_step(residual, RATE_HZ, STEP) is None
    assert first_out_of_step(residual + np.where(t < 1.2, 0.0, 4.0 * STEP), RATE_HZ, STEP) == 1200
