"""Runs of one mechanism side by side, and each of them alone."""

import numpy as np

from mechid.command import Command, RateProfile, Timing
from mechid.simulation.batch import Batch
from mechid.simulation.simulator import TimeBase

SWINGING = RateProfile.through(
    [(0.0, 10.0), (0.1, 80.0), (0.2, 80.0), (0.2, -40.0), (0.35, 0.0), (0.4, 0.0), (0.5, 90.0)]
)
MICRO = Command(stepping="micro", microsteps=8, rate=SWINGING, start_angle_deg=17.0)
FULL = Command(stepping="full", microsteps=1, rate=RateProfile.constant(46.0), start_angle_deg=45.0)
BASE = TimeBase(1e4, 6001)


def begun(simulator, points, *, substeps=1, offsets=(0.0,), ppm=(0.0,), samples=None):
    """Return runs that have begun, one a point; offsets and clocks in turn."""
    none = np.zeros((len(points[0]), 0))
    return [
        simulator.run(
            p,
            directions=none,
            events=500,
            substeps=substeps,
            timing=Timing(offsets[k % len(offsets)], ppm[k % len(ppm)]),
            samples=samples,
        )
        for k, p in enumerate(points)
    ]


def around(mechanism, count, spread=0.02, seed=5):
    """Return points around a mechanism's values, (count, n_p)."""
    p, rng = mechanism.kernel_values(), np.random.default_rng(seed)
    return p * (1.0 + spread * rng.standard_normal((count, p.size)) * (p != np.round(p)))


def alone(runs):
    """Return the outputs of each run by itself, (runs, n, n_y)."""
    return np.array([np.concatenate([block.y.copy() for block in run.blocks()]) for run in runs])


def together(runs):
    """Return the outputs of the same runs side by side, (runs, n, n_y)."""
    parts = [y.copy() for _, _, y in Batch(runs).blocks()]
    return np.concatenate(parts, axis=1)


def assert_same(simulator, points, **how):
    """Truth: the kernel alone, with the same switches, and 1e-9 of the RMS."""
    one, other = begun(simulator, points, **how), begun(simulator, points, **how)
    expected, found = alone(one), together(other)
    scale = np.sqrt(np.mean(expected**2, axis=(1, 2)))
    error = np.sqrt(np.mean((found - expected) ** 2, axis=(1, 2)))
    assert np.all(error <= 1e-9 * scale), error / scale
    for a, b in zip(one, other, strict=True):
        assert b.outcome is a.outcome
        np.testing.assert_array_equal(b.switching.switch, a.switching.switch)
        np.testing.assert_allclose(b.switching.time, a.switching.time, atol=1e-9)
        np.testing.assert_allclose(b.state.x, a.state.x, rtol=1e-8, atol=1e-9)
