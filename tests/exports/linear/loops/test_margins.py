"""Margins of sampled loops. Truth: closed forms, python-control, and poles that reach the unit circle."""

import math

import numpy as np
import pytest

from mechid.exports.linear.loops.controllers import current_controller
from mechid.exports.linear.loops.loop_file import CurrentLoop, SampledTiming
from mechid.exports.linear.loops.margins import margins_of, unstable_pole
from mechid.exports.linear.loops.sampled import Sampled, close, hold, series
from mechid.exports.linear.state_space import Matrices

R, L, T = 9.9, 0.045, 1e-4


def coil(delay_s):
    plant = Matrices(np.array([[-R / L]]), np.array([[1.0 / L]]), np.eye(1), np.zeros((1, 1)))
    return hold(plant, ("u",), ("i",), T, delayed=("u",), delay_s=delay_s)


def pi(kp, ki):
    return current_controller(CurrentLoop(kp=kp, ki=ki, timing=SampledTiming(period_s=T, delay_s=T)), "i", "u")


def scaled(loop, factor):
    A, B, C, D = loop.matrices.all
    return Sampled(Matrices(A, B, factor * C, factor * D), loop.period_s, loop.inputs, loop.outputs)


def unity(loop):
    """Return the loop closed by 1."""
    A, B, C, D = loop.matrices.all
    back = 1.0 / (1.0 + D[0, 0])
    return Sampled(Matrices(A - B @ C * back, B * back, C * back, D * back), loop.period_s, ("r",), loop.outputs)


@pytest.mark.parametrize("delay", [1, 2, 3])
def test_margins_of_a_held_integrator_with_a_delay(delay):
    """Truth: L = g T z^-d/(z - 1), |L| = g T/(2 sin(w T/2)), arg L = -90 deg - w T (d + 1/2)."""
    g = 600.0
    plant = Matrices(np.zeros((1, 1)), np.array([[g]]), np.eye(1), np.zeros((1, 1)))
    found = margins_of(hold(plant, ("u",), ("y",), T, delayed=("u",), delay_s=delay * T))
    turn = math.pi / (1.0 + 2.0 * delay)
    assert found.gain_dB == pytest.approx(20.0 * math.log10(2.0 * math.sin(turn / 2.0) / (g * T)), abs=1e-8)
    assert found.gain_frequency_hz == pytest.approx(turn / (2.0 * math.pi * T), rel=1e-8)
    across = 2.0 * math.asin(g * T / 2.0)
    phase = 90.0 - math.degrees(across * (delay + 0.5))
    assert found.phase_deg == pytest.approx(phase, abs=1e-7)
    assert found.phase_frequency_hz == pytest.approx(across / (2.0 * math.pi * T), rel=1e-8)
    assert found.delay_s == pytest.approx(math.radians(phase) * T / across, rel=1e-7)
    assert found.reduction_dB == math.inf


@pytest.mark.parametrize("delay", [0.5, 1.0, 1.7, 2.0])
def test_margins_of_a_coil_under_pi_are_those_of_python_control(delay):
    """Truth: python-control's margins of its own discrete system."""
    control = pytest.importorskip("control")
    loop = series(pi(100.0, 20000.0), coil(delay * T))
    found = margins_of(loop)
    gain, phase, distance, at, across, _ = control.stability_margins(control.ss(*loop.matrices.all, T))
    assert found.gain_dB == pytest.approx(20.0 * math.log10(gain), abs=1e-5)
    assert found.phase_deg == pytest.approx(phase, abs=1e-3)
    assert found.gain_frequency_hz == pytest.approx(at / (2.0 * math.pi), rel=1e-5)
    assert found.phase_frequency_hz == pytest.approx(across / (2.0 * math.pi), rel=1e-4)
    assert found.sensitivity_peak == pytest.approx(1.0 / distance, rel=1e-3)


def test_the_zero_order_hold_and_the_delay_are_python_controls():
    """Truth: python-control's c2d times z^-2, at single frequencies."""
    control = pytest.importorskip("control")
    plant = control.c2d(control.tf([1.0], [L, R]), T, "zoh") * control.tf([1.0], [1.0, 0.0, 0.0], T)
    hertz = np.array([3.0, 300.0, 4000.0])
    expected = plant(np.exp(2j * np.pi * hertz * T))
    np.testing.assert_allclose(coil(2.0 * T).response(hertz)[:, 0, 0], expected, rtol=1e-9)


@pytest.mark.parametrize("delay", [0.0, 1.0, 1.5])
def test_the_gain_margin_brings_a_pole_to_the_unit_circle(delay):
    """Truth: eigenvalues of the loop closed with just less and just more gain; without delay at half the rate."""
    loop = series(pi(100.0, 20000.0), coil(delay * T))
    factor = 10.0 ** (margins_of(loop).gain_dB / 20.0)
    assert unstable_pole(unity(scaled(loop, 0.9999 * factor))) is None
    assert abs(unstable_pole(unity(scaled(loop, 1.0001 * factor)))) == pytest.approx(1.0, abs=1e-3)


def test_the_delay_margin_brings_a_pole_to_the_unit_circle():
    """Truth: eigenvalues of the loop with as many more samples of delay as fit, and with one more."""
    samples = int(margins_of(series(pi(100.0, 20000.0), coil(T))).delay_s / T)
    assert samples == 5
    assert unstable_pole(close(coil((1 + samples) * T), pi(100.0, 20000.0), ("r",))) is None
    assert unstable_pole(close(coil((2 + samples) * T), pi(100.0, 20000.0), ("r",))) is not None


def test_a_conditionally_stable_loop_has_a_reduction_as_well():
    """Truth: an unstable plant needs gain: eigenvalues at both ends of its range."""
    plant = Matrices(np.array([[300.0]]), np.array([[1.0]]), np.eye(1), np.zeros((1, 1)))
    loop = scaled(hold(plant, ("u",), ("y",), T, delayed=("u",), delay_s=T), 1200.0)
    found = margins_of(loop)
    assert unstable_pole(unity(loop)) is None
    for dB in (-found.reduction_dB, found.gain_dB):
        inside, outside = (10.0 ** (share * dB / 20.0) for share in (0.999, 1.001))
        assert unstable_pole(unity(scaled(loop, inside))) is None
        assert unstable_pole(unity(scaled(loop, outside))) is not None


def test_the_crossover_of_a_slow_integrator_is_found():
    """Truth: |L| = 1 where g = w, far below every other frequency of the loop."""
    plant = Matrices(
        np.array([[0.0, 1e-4], [0.0, -500.0]]), np.array([[0.0], [500.0]]), np.eye(2)[:1], np.zeros((1, 1))
    )
    found = margins_of(hold(plant, ("u",), ("y",), T))
    assert found.phase_frequency_hz == pytest.approx(1e-4 / (2.0 * math.pi), rel=1e-6)
    assert found.phase_deg == pytest.approx(90.0, abs=1e-3)
