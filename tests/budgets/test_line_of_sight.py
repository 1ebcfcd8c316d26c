"""From lines of the torque to the line of sight. Truth: the modes driven in time, and their sum written out."""

import numpy as np
import pytest
from scipy import signal

from mechid.budgets.line_of_sight import respond
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.steady_state import steady_state
from mechid.command import Command, RateProfile
from mechid.structure import Modes, Structure

MICRO = Command(stepping="micro", microsteps=16, rate=RateProfile.constant(37.3))
SCAN = OperatingMode(name="scan", command=MICRO, rates=np.array([37.3]), settle_s=1.0, highest_hz=300.0)
PAYLOAD = Modes(np.array([35.0]), np.array([0.01]), np.array([0.2]), np.array([[0.05]]))
STRUCTURE = Structure(name="s", line_of_sight=("x",), model=PAYLOAD)


def test_the_line_of_sight_is_that_of_the_modes_driven_in_time(state, long_run):
    """Truth: the oscillator integrated under the simulated torque until its transient is gone."""
    A, B, C = PAYLOAD.state_space()
    rate = 20_000.0
    Ad, Bd, Cd, Dd, _ = signal.cont2discrete((A, B, C[1:], np.zeros((1, 1))), 1.0 / rate, method="foh")
    _, y, _ = signal.dlsim((Ad, Bd, Cd, Dd, 1.0 / rate), long_run)
    response = respond(state, STRUCTURE)
    assert response.rms()[0] == pytest.approx(y[70_000:, 0].std(), rel=5e-3)


def test_one_mode_against_the_closed_form(flying):
    """Truth: RMS of psi phi |T_k| / |w0^2 - w^2 + 2 i z w0 w| over the lines, written out."""
    state = steady_state(flying.mechanism, SCAN, 37.3, (), 4)
    w, w0 = 2.0 * np.pi * 0.5 * 37.3 * state.orders, 2.0 * np.pi * 35.0
    inside = w <= 2.0 * w0
    size = 0.2 * 0.05 * np.abs(state.lines) / np.hypot(w0**2 - w**2, 2.0 * 0.01 * w0 * w)
    expected = np.sqrt(0.5 * np.sum(size[inside] ** 2))
    assert respond(state, STRUCTURE).rms()[0] == pytest.approx(expected, rel=1e-12)
