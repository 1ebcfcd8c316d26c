"""Runs side by side in one kernel, against each of them alone."""

import numpy as np
import pytest

from golden_variants import VARIANTS
from layouts import LAYOUTS, changed, mechanism_of, paper_table
from mechid.command import Command, RateProfile, Timing
from mechid.simulation.batch import SETS, Batch
from mechid.simulation.noted import joined
from mechid.simulation.simulator import Simulator, TimeBase
from mechid.simulation.trajectory import SimulationOutcome

SWINGING = RateProfile.through(
    [(0.0, 10.0), (0.1, 80.0), (0.2, 80.0), (0.2, -40.0), (0.35, 0.0), (0.4, 0.0), (0.5, 90.0)]
)
MICRO = Command(stepping="micro", microsteps=8, rate=SWINGING, start_angle_deg=17.0)
FULL = Command(stepping="full", microsteps=1, rate=RateProfile.constant(46.0), start_angle_deg=45.0)
BASE = TimeBase(1e4, 6001)
DEFAULT = ("paper", "direct_torque_drive")


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


@pytest.mark.parametrize(
    "name", [name if name in DEFAULT else pytest.param(name, marks=pytest.mark.slow) for name in VARIANTS]
)
def test_each_run_is_what_it_is_alone(name):
    """Truth: the kernel alone; a command that reverses, rests and jumps; records early, late, off the clock."""
    mechanism = mechanism_of(VARIANTS[name])
    simulator = Simulator(mechanism.plant, MICRO, BASE, latest_s=0.1)
    assert_same(simulator, around(mechanism, SETS), offsets=(0.0, 1e-3, 0.013, -2e-4), ppm=(0.0, 300.0, -50.0))


def test_what_some_do_while_others_rest_is_noted():
    """Truth: the kernel alone; records of which one begins late, and the others move in the meantime."""
    mechanism = mechanism_of(paper_table())
    simulator = Simulator(mechanism.plant, MICRO, BASE, latest_s=0.1)
    points, offsets = around(mechanism, SETS), (0.0, 1e-3, 0.013, -2e-4)
    (first, *_) = begun(simulator, points, offsets=offsets)
    alone([first])
    assert first.switching.time[0] < 0.013
    assert_same(simulator, points, offsets=offsets)


@pytest.mark.parametrize("late_s", [0.0, pytest.param(0.113, marks=pytest.mark.slow)])
def test_jumps_are_those_of_each_alone(late_s):
    """Truth: the kernel alone; block by block, whatever the blocks, also of a run that moves while another rests."""
    mechanism = mechanism_of(changed(paper_table(), LAYOUTS["backlash"]))
    simulator = Simulator(mechanism.plant, MICRO, BASE, latest_s=0.2)
    points, none = around(mechanism, SETS), np.zeros((len(mechanism.kernel_values()), 0))

    def runs():
        return [
            simulator.run(p, directions=none, events=None, timing=Timing(k % 2 * late_s)) for k, p in enumerate(points)
        ]

    def noted(run):
        return joined([block.jumps.later(block.start) for block in run.blocks()])

    together = [[] for _ in points]
    for blocks in zip(*(run.blocks() for run in Batch(runs()).each()), strict=True):
        for found, block in zip(together, blocks, strict=True):
            found.append(block.jumps.later(block.start))
    for expected, found in zip(map(noted, runs()), map(joined, together), strict=True):
        assert expected.samples.size > 4
        np.testing.assert_array_equal(found.samples, expected.samples)
        np.testing.assert_allclose(found.since, expected.since, atol=1e-5)
        np.testing.assert_allclose(found.rises, expected.rises, rtol=1e-6, atol=1e-9)


@pytest.fixture(scope="module")
def paper():
    """The paper's mechanism."""
    return mechanism_of(VARIANTS["paper"])


@pytest.mark.parametrize("count", [1, 3, SETS])
def test_there_may_be_fewer(paper, count):
    """Truth: the kernel alone."""
    assert_same(Simulator(paper.plant, FULL, BASE), around(paper, count))


def test_steps_may_be_shorter_than_samples(paper):
    """Truth: the kernel alone, four steps a sample."""
    assert_same(Simulator(paper.plant, FULL, TimeBase(2500.0, 1500)), around(paper, SETS), substeps=4)


def test_angles_may_turn_far_in_a_step(paper):
    """Truth: the kernel alone, at 3000 full steps a second, where half an electrical period passes in 7 samples."""
    fast = Command(stepping="micro", microsteps=16, rate=RateProfile.through([(0.0, 100.0), (0.4, 3000.0)]))
    assert_same(Simulator(paper.plant, fast, TimeBase(1e4, 5001)), around(paper, SETS))


@pytest.mark.parametrize("offsets", [(0.0,), (0.0, 0.2)], ids=["all begin at once", "others still rest"])
def test_one_that_fails_takes_nobody_with_it(paper, offsets):
    """Truth: the kernel alone; the third cannot be simulated."""
    points = around(paper, SETS)
    inertia = [str(s) for s in paper.plant.parameters].index("J_rot")
    points[2, inertia] *= -1e-3
    simulator = Simulator(paper.plant, FULL, BASE, latest_s=0.2)
    runs, same = begun(simulator, points, offsets=offsets), begun(simulator, points, offsets=offsets)
    expected, found = alone(runs), together(same)
    assert same[2].outcome is runs[2].outcome is not SimulationOutcome.COMPLETE
    np.testing.assert_array_equal(np.isnan(found), np.isnan(expected))
    kept = [k for k in range(SETS) if k != 2]
    np.testing.assert_allclose(found[kept], expected[kept], atol=1e-9 * np.abs(expected[kept]).max())


def test_the_order_of_sets_does_not_matter(paper):
    """Truth: the same sets in another order, to 1e-12 of the largest."""
    points = around(paper, SETS)
    simulator, order = Simulator(paper.plant, MICRO, BASE), np.random.default_rng(1).permutation(SETS)
    one, other = together(begun(simulator, points)), together(begun(simulator, points[order]))
    np.testing.assert_allclose(other, one[order], atol=1e-12 * np.abs(one).max())
