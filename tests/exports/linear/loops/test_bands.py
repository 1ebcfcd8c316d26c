"""Bands of margins, Bode diagram and step response. Truth: closed forms of a coil whose resistance is drawn."""

import numpy as np
import pytest

from mechid.exports.linear.loops.bands import band_of, loop_numbers, step_response
from mechid.exports.linear.loops.closing import Loop
from mechid.exports.linear.loops.controllers import current_controller
from mechid.exports.linear.loops.loop_file import CurrentLoop, SampledTiming
from mechid.exports.linear.loops.margins import margins_of
from mechid.exports.linear.loops.sampled import close, hold, series
from mechid.exports.linear.state_space import Matrices

T = 1e-4


def loop(inductance, kp=100.0, ki=20000.0):
    plant = Matrices(np.array([[-9.9 / inductance]]), np.array([[1.0 / inductance]]), np.eye(1), np.zeros((1, 1)))
    held = hold(plant, ("u",), ("i",), T, delayed=("u",), delay_s=T)
    own = current_controller(CurrentLoop(kp=kp, ki=ki, timing=SampledTiming(period_s=T, delay_s=T)), "i", "u")
    return Loop(held, own, series(own, held), close(held, own, ("r",)))


def test_a_band_is_of_whole_draws():
    """Truth: the order of 41 numbers, one of them infinite."""
    band = band_of(7.0, [*range(40), np.inf])
    assert (float(band.value), float(band.low), float(band.high)) == (7.0, 1.0, 39.0)
    assert band_of([1.0, 2.0], []).to_dict() == {"value": [1.0, 2.0], "low": [1.0, 2.0], "high": [1.0, 2.0]}
    assert band_of(np.inf, [1.0, np.inf]).to_dict() == {"value": None, "low": 1.0, "high": None}


def test_the_numbers_of_a_loop_are_those_of_its_draws():
    """Truth: margins of two draws on their own; the more inductance, the less gain."""
    most, least = loop(0.06), loop(0.03)
    numbers = loop_numbers(loop(0.045), [most, least])
    gains = [margins_of(one.open).gain_dB for one in (most, least)]
    assert (float(numbers.bands["gain_dB"].high), float(numbers.bands["gain_dB"].low)) == pytest.approx(gains)
    np.testing.assert_allclose(
        numbers.magnitude_dB.low, 20.0 * np.log10(np.abs(most.open.response(numbers.frequency_hz)[:, 0, 0])), atol=0.2
    )
    assert numbers.unstable_draws == 0
    assert np.all(np.abs(np.diff(numbers.phase_deg.value)) < 90.0)


def test_an_unstable_draw_counts_with_a_negative_margin():
    """Truth: its gain lies above the margin by so much."""
    shaky = loop(0.009)
    numbers = loop_numbers(loop(0.045), [loop(0.045)] * 3 + [shaky])
    assert numbers.unstable_draws == 1
    assert float(numbers.bands["gain_dB"].low) == pytest.approx(-margins_of(shaky.open).reduction_dB)
    assert float(numbers.bands["phase_deg"].low) < 0.0


def test_a_step_of_a_coil_without_integral_is_the_recursion():
    """Truth: i[k+1] = phi i[k] + gamma kp (1 - i[k-1]), typed out; it ends at kp/(kp + R)."""
    one = loop(0.045, kp=60.0, ki=0.0)
    step = step_response(one.closed, [], "r", ("i", "control_u"))
    phi = np.exp(-9.9 / 0.045 * T)
    gamma = (1.0 - phi) / 9.9
    i, u = [0.0], 0.0
    for _ in range(round(step.time_s[-1] / T)):
        now = 60.0 * (1.0 - i[-1])
        i.append(phi * i[-1] + gamma * u)
        u = now
    np.testing.assert_allclose(step.outputs["i"].value, np.array(i)[np.round(step.time_s / T).astype(int)], atol=1e-12)
    assert i[-1] == pytest.approx(60.0 / 69.9, rel=0.01)
    assert float(step.overshoot.value) == pytest.approx(max(i) - i[-1])
    settled = round(float(step.settling_s.value) / T)
    assert np.all(np.abs(np.array(i[settled:]) - i[-1]) <= 0.02)
    assert abs(i[settled - 1] - i[-1]) > 0.02
