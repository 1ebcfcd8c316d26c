"""A run whose derivatives are shared among threads; truth: the same run on one thread, to the last bit."""

from dataclasses import replace

import numpy as np
import pytest

import paper
from mechid.command import Timing
from mechid.simulation.divided import DividedRun, divide_lanes
from mechid.simulation.interruption import interrupt_by
from mechid.simulation.simulator import Simulator, TimeBase
from mechid.simulation.start import Start
from mechid.simulation.trajectory import SimulationOutcome
from mechid.simulation.work import work_counter

BASE = TimeBase(10_000.0, 5000)
DIRECTIONS = 14
"""Four groups of lanes, the last one half empty, of which three are used in whole."""


@pytest.fixture(scope="module")
def mechanism():
    return paper.mechanism()


@pytest.fixture(scope="module")
def simulator(mechanism):
    return Simulator(mechanism.plant, paper.RECORDS["full_23"], BASE, latest_s=0.1, capacity=DIRECTIONS)


@pytest.fixture(scope="module")
def directions(mechanism):
    """Return combinations of all parameters, (n_p, m), in their own sizes."""
    size = np.abs(mechanism.kernel_values())[:, np.newaxis]
    return size * np.random.default_rng(4).standard_normal((size.shape[0], DIRECTIONS))


def consumed(run):
    """Return outputs, rates, derivatives, jumps, outcome and work of a run."""
    with work_counter() as work:
        blocks = [(b.y.copy(), b.rate.copy(), b.jacobian.copy(), b.jumps) for b in run.blocks()]
    y, rate, jacobian = (np.concatenate(each) for each in list(zip(*blocks, strict=True))[:3])
    jumps = [jumps.since for *_, jumps in blocks]
    return y, rate, jacobian, np.concatenate(jumps), run.outcome, work.done


@pytest.mark.parametrize("threads", [1, 2, 3, 9])
@pytest.mark.parametrize("timing", [Timing(0.01), Timing(0.01, 400.0)])
def test_the_values_are_those_of_one_thread(simulator, mechanism, directions, threads, timing):
    p, options = mechanism.kernel_values(), {"timing": timing, "events": None}
    true = consumed(simulator.run(p, directions=directions, **options))
    found = consumed(DividedRun(simulator, p, directions, threads, **options))
    assert np.all(np.ptp(true[2], axis=0)[0, :DIRECTIONS] > 0.0)  # each derivative moves
    for one, other in zip(found, true, strict=True):
        np.testing.assert_array_equal(one, other)


def test_lanes_that_carry_a_start_move_on_their_own_thread(simulator, mechanism, directions):
    start = Start({"start.rate": 0.2}, {2: {"start.rate": 1.0}, 13: {"start.twist": 0.5}})
    own, p = replace(simulator, start=start), mechanism.kernel_values()
    true = consumed(own.run(p, directions=directions))
    for one, other in zip(consumed(DividedRun(own, p, directions, 3)), true, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_run_that_is_lost_says_so(simulator, mechanism, directions):
    p = np.full_like(mechanism.kernel_values(), np.nan)
    assert consumed(DividedRun(simulator, p, directions, 2))[4] is not SimulationOutcome.COMPLETE


def test_it_can_be_interrupted_and_left_halfway(simulator, mechanism, directions):
    class StoppedError(BaseException):
        pass

    def stop():
        raise StoppedError

    run = DividedRun(simulator, mechanism.kernel_values(), directions, 2)
    blocks = run.blocks()
    next(blocks)
    blocks.close()
    again = DividedRun(simulator, mechanism.kernel_values(), directions, 2)
    with interrupt_by(stop), pytest.raises(StoppedError):
        list(again.blocks())


def test_whole_groups_are_divided_as_evenly_as_can_be():
    assert divide_lanes(14, 2) == [slice(0, 8), slice(8, 14)]
    assert divide_lanes(20, 4) == [slice(0, 8), slice(8, 12), slice(12, 16), slice(16, 20)]
    assert divide_lanes(3, 4) == [slice(0, 3)]
    assert [n for part in divide_lanes(50, 7) for n in range(50)[part]] == list(range(50))
