"""The line of sight over time, against closed forms of the oscillator and of the free body."""

import numpy as np
import pytest

from mechid.structure import FrequencyResponse, Modes, Structure
from mechid.structure.in_time import line_of_sight_over_time

RATE_HZ = 2000.0
T = np.arange(8000) / RATE_HZ


def moved(model, torque):
    structure = Structure(name="s", line_of_sight=("x",), model=model)
    return next(line_of_sight_over_time(structure, torque[:, None], RATE_HZ, 500.0))[:, 0]


def one_mode(frequency, damping=0.0):
    return Modes(np.array([frequency]), np.array([damping]), np.array([0.2]), np.array([[0.05]]))


def test_a_step_of_torque_on_one_mode():
    """Truth: (1 - e^(-z w t) (cos + z/sqrt(1 - z^2) sin))/w^2; the ramp to the first sample is half a sample late."""
    w, z = 2.0 * np.pi * 11.0, 0.02
    damped = w * np.sqrt(1.0 - z**2)
    t = T + 0.5 / RATE_HZ
    closed = 0.01 / w**2 * (1.0 - np.exp(-z * w * t) * (np.cos(damped * t) + z * w / damped * np.sin(damped * t)))
    np.testing.assert_allclose(moved(one_mode(11.0, z), np.ones_like(T)), closed, atol=1e-3 * closed.max())


def test_a_free_body_under_a_growing_torque():
    """Truth: t^3/6 by a torque t, exactly linear between its samples."""
    np.testing.assert_allclose(moved(one_mode(0.0), T), 0.01 * T**3 / 6.0, rtol=1e-9, atol=1e-15)


def test_a_sine_settles_to_the_transfer_function():
    """Truth: |H| of the modes."""
    modes, f = one_mode(20.0, 0.05), 23.0
    settled = moved(modes, np.cos(2.0 * np.pi * f * T))[4000:]
    assert np.abs(settled).max() == pytest.approx(abs(modes.response(np.array([f]))[0, 1]), rel=1e-3)


def test_a_response_says_the_same_as_its_modes():
    """Truth: the modes in closed form. The response is theirs on a grid, a torque of one second, then quiet."""
    modes = one_mode(20.0, 0.03)
    f = np.arange(0.0, 500.0, 0.1)
    torque = np.where(T < 1.0, np.sin(2.0 * np.pi * 17.0 * T), 0.0)
    got = moved(FrequencyResponse(f, modes.response(f)), torque)
    expected = moved(modes, torque)
    np.testing.assert_allclose(got, expected, atol=5e-3 * np.abs(expected).max())
