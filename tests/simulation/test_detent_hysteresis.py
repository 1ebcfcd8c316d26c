"""Hysteresis of the detent torque in the kernel. Truth: the closed form of Dahl's model between two reversals."""

import numpy as np

from kernel_state import twin_state
from layouts import LAYOUTS, paper_with
from paper import constant
from runs import SUBSTEPS, base, simulator

TORQUE, ANGLE = 0.004, np.radians(20.0)


def along():
    """Return states by name, (N,) each, of a motor that swings after each of five steps a second."""
    light = {"static": 0.004, "coulomb": 0.002, "viscous": 2e-4}
    mechanism = paper_with({**LAYOUTS["detent hysteresis"], "friction": light, "housing": None})
    run = simulator(mechanism, constant(5.0), base(0.5)).run(mechanism.kernel_values(), substeps=SUBSTEPS, block=1)
    states = np.array([twin_state(run).s for _ in run.blocks()])
    return dict(zip(map(str, mechanism.plant.states), states.T, strict=True))


def test_it_builds_up_and_turns_as_in_closed_form():
    """Truth: between reversals 1 - h sign(dx) falls with exp(-abs(dx)/theta); work is never given, and is bounded."""
    s = along()
    x, h, speed = 50.0 * s["alpha"], s["h_detent"], s["omega"]
    steady = (np.sign(speed[1:]) == np.sign(speed[:-1])) & (speed[1:] != 0.0)
    # A reversal and back within one sample would leave equal signs: the way is then shorter than the speeds say.
    sign, way = np.sign(speed[1:])[steady], np.diff(x)[steady]
    before, after = h[:-1][steady], h[1:][steady]
    np.testing.assert_allclose(1.0 - sign * after, (1.0 - sign * before) * np.exp(-np.abs(way) / ANGLE), atol=2e-7)
    assert np.abs(h).max() <= 1.0
    assert (np.diff(np.sign(speed[speed != 0.0])) != 0).sum() > 10
    # Over the whole run from h = 0: theta dh = dx - h abs(dx), so that the work of a run is never negative.
    assert TORQUE * np.sum(0.5 * (h[1:] + h[:-1]) * np.diff(x)) / 50.0 > 0.0
