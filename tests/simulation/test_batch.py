"""Runs side by side in one kernel, against each of them alone."""

import pytest

from golden_variants import VARIANTS
from layouts import mechanism_of, paper_table
from mechid.command import Command, RateProfile
from mechid.simulation.batch import SETS
from mechid.simulation.simulator import Simulator, TimeBase
from side_by_side import BASE, FULL, MICRO, alone, around, assert_same, begun

DEFAULT = ("paper", "direct_torque_drive")


@pytest.mark.slow
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
