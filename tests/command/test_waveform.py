"""Normalised phase voltages against their definition and their symmetries."""

import numpy as np
import pytest

from mechid.command.waveform import phase_voltages


@pytest.mark.parametrize("n", [1, 2, 3, 7, 16, 256])
@pytest.mark.parametrize("start_deg", [0.0, 45.0, -17.3, 1234.5])
def test_cosine_wave(n, start_deg):
    """Truth: e_A = -cos theta, e_B = sin theta, in longer floats."""
    k = np.arange(-5 * n, 5 * n + 1)
    theta = np.deg2rad(np.longdouble(start_deg) + k * np.longdouble(90) / n)
    expected = np.stack([-np.cos(theta), np.sin(theta)], axis=1).astype(float)
    found = phase_voltages(k, n, start_deg, "cosine")
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-15 * (2 + abs(start_deg) / 90))


@pytest.mark.parametrize("n", [1, 2, 7, 16])
def test_a_high_index_is_as_exact_as_the_first(n):
    """Truth: theta turns once in 4 n steps, so the voltages repeat bit for bit."""
    k = np.arange(4 * n)
    first = phase_voltages(k, n, 33.3, "cosine")
    np.testing.assert_array_equal(phase_voltages(k + 4 * n * 25_000, n, 33.3, "cosine"), first)
    np.testing.assert_array_equal(phase_voltages(k - 4 * n * 25_000, n, 33.3, "cosine"), first)


@pytest.mark.parametrize("waveform", ["cosine", "square"])
@pytest.mark.parametrize("n", [1, 3, 7, 16])
def test_exact_at_the_quarter_turns(n, waveform):
    """Truth: cosine and sine of 0, 90, 180, 270 deg, without negative zeros."""
    k = n * (np.arange(4) + 100_000)
    found = phase_voltages(k, n, 0.0, waveform)
    np.testing.assert_array_equal(found, [[-1, 0], [0, 1], [1, 0], [0, -1]])
    assert not np.any(np.signbit(found[found == 0.0]))


def test_a_rounded_start_angle_still_meets_the_quarter_turn():
    """Truth: 6/7 of 90 deg less a turn, and 1/7 of 90 deg, are -270 deg; floats miss it by 6e-14."""
    start_deg = 77.14285714285714 - 360.0
    assert start_deg + 90 / 7 != -270.0
    np.testing.assert_array_equal(phase_voltages(np.array([1]), 7, start_deg, "square"), [[0.0, 1.0]])


def test_square_wave_of_half_steps():
    """Truth: the eight half steps from 0 deg by hand: one phase off at every other."""
    expected = [[-1, 0], [-1, 1], [0, 1], [1, 1], [1, 0], [1, -1], [0, -1], [-1, -1]]
    np.testing.assert_array_equal(phase_voltages(np.arange(8), 2, 0.0, "square"), expected)


def test_square_wave_of_full_steps():
    """Truth: from 45 deg both phases are always on; the current vector turns by a quarter a step."""
    expected = [[-1, 1], [1, 1], [1, -1], [-1, -1]]
    np.testing.assert_array_equal(phase_voltages(np.arange(4), 1, 45.0, "square"), expected)


SIX_STATES = [[-1, 1, 1], [-1, 1, -1], [1, 1, -1], [1, -1, -1], [1, -1, 1], [-1, -1, 1]]
"""Terminals A, B, C of a star at steps of 60 deg from 0 deg: -cos(theta), -cos(theta + 120), -cos(theta + 240 deg)."""
TWO_ON = [[-1, 1, 0], [0, 1, -1], [1, 0, -1], [1, -1, 0], [0, -1, 1], [-1, 0, 1]]
"""The same from 30 deg on: one terminal at the supply's middle."""


@pytest.mark.parametrize(("start_deg", "states"), [(0.0, SIX_STATES), (30.0, TWO_ON)])
def test_six_states_of_three_phases(start_deg, states):
    """Truth: the table of states, less their mean, projected on phase A and across it."""
    terminals = np.array(states, dtype=float)
    phases = terminals - terminals.mean(axis=1, keepdims=True)
    across = (phases[:, 1] - phases[:, 2]) / np.sqrt(3.0)
    found = phase_voltages(np.arange(-6, 12), 1, start_deg, "square", 3)
    np.testing.assert_allclose(found, np.tile(np.stack([phases[:, 0], across], axis=1), (3, 1)), rtol=0, atol=1e-15)


def test_the_cosine_of_three_phases_turns_by_sixty_degrees():
    """Truth: the vector of two phases, at steps of 60 deg."""
    found = phase_voltages(np.arange(13), 2, 0.0, "cosine", 3)
    theta = np.radians(30.0 * np.arange(13))
    np.testing.assert_allclose(found, np.stack([-np.cos(theta), np.sin(theta)], axis=1), rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("n", "start_deg", "steps"),
    [
        (1, 0.0, "a B A b"),
        (1, 45.0, "aB BA Ab ba"),
        (2, 0.0, "a aB B BA A Ab b ba"),
    ],
)
def test_wave_full_and_half_stepping_of_four_phases(n, start_deg, steps):
    """Truth: the sequences of a unipolar driver; a capital is the half of a pole that pulls with its phase."""
    signs = {"A": (1, 0), "a": (-1, 0), "B": (0, 1), "b": (0, -1)}
    expected = [np.sum([signs[half] for half in step], axis=0) for step in steps.split()]
    found = phase_voltages(np.arange(4 * n), n, start_deg, "square", 4)
    np.testing.assert_array_equal(found, expected)
