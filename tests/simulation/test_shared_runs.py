"""Runs kept for repetition; truth: the same run simulated by itself, to the last bit."""

from dataclasses import replace

import numpy as np
import pytest

import paper
from mechid.command import Timing
from mechid.simulation.shared_runs import KeptRun, SharedRuns
from mechid.simulation.simulator import PLAIN_BLOCK, Run, Simulator, TimeBase
from mechid.simulation.trajectory import SimulationOutcome
from mechid.simulation.work import work_counter

BASE = TimeBase(10_000.0, PLAIN_BLOCK + 3000)


def simulator(mechanism, name="full_23", base=BASE):
    return Simulator(mechanism.plant, paper.RECORDS[name], base)


def consumed(run):
    """Outputs, jumps, outcome and work of a run."""
    with work_counter() as work:
        blocks = [(b.start, b.y.copy(), b.jumps) for b in run.blocks()]
    places = [start + jumps.samples for start, _, jumps in blocks]
    rises = [jumps.rises for *_, jumps in blocks if jumps.samples.size]
    y = np.concatenate([y for _, y, _ in blocks])
    return y, np.concatenate(places), np.concatenate(rises or [y[:0]]), run.outcome, work.done


def alone(simulated, p, **named):
    return consumed(simulated.run(p, events=None, **named))


def assert_equal(found, true):
    for one, other in zip(found, true, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.fixture(scope="module")
def mechanism():
    return paper.mechanism()


def test_a_kept_run_is_the_run_itself(mechanism):
    runs, simulated, p = SharedRuns(), simulator(mechanism), mechanism.kernel_values()
    true = alone(simulated, p)
    assert_equal(consumed(runs.begin(simulated, p)), true)
    # Another simulator of the same record finds its edges anew.
    again = runs.begin(simulator(mechanism), p)
    assert isinstance(again, KeptRun)
    assert_equal(consumed(again), true)


def test_it_may_be_repeated_in_shorter_blocks(mechanism):
    runs, simulated, p = SharedRuns(), simulator(mechanism), mechanism.kernel_values()
    consumed(runs.begin(simulated, p))
    short = runs.begin(simulated, p, block=1024)
    assert isinstance(short, KeptRun)
    assert_equal(consumed(short), alone(simulated, p, block=1024))


@pytest.mark.parametrize(
    "named", [{"substeps": 2}, {"timing": Timing(1e-4)}, {"timing": Timing(0.0, 50.0)}, {"samples": PLAIN_BLOCK + 1}]
)
def test_another_simulation_is_not_taken_for_it(mechanism, named):
    runs, simulated, p = SharedRuns(), simulator(mechanism), mechanism.kernel_values()
    consumed(runs.begin(simulated, p))
    other = runs.begin(simulated, p, **named)
    assert not isinstance(other, KeptRun)
    assert_equal(consumed(other), alone(simulated, p, **named))


def test_nor_is_another_point_or_another_command(mechanism):
    runs, p = SharedRuns(), mechanism.kernel_values()
    consumed(runs.begin(simulator(mechanism), p))
    turned = replace(paper.RECORDS["full_23"], start_angle_deg=46.0)
    others = (
        (simulator(mechanism), p * (1.0 + 1e-15)),
        (simulator(mechanism, "full_46"), p),
        (Simulator(mechanism.plant, turned, BASE), p),
    )
    assert not any(isinstance(runs.begin(*other), KeptRun) for other in others)


def test_jumps_are_kept_and_hold_for_blocks_of_their_size_alone():
    rigid = paper.mechanism(housing=None)
    runs, simulated, p = SharedRuns(), simulator(rigid), rigid.kernel_values()
    true = alone(simulated, p)
    assert true[1].size
    consumed(runs.begin(simulated, p))
    assert_equal(consumed(runs.begin(simulated, p)), true)
    short = runs.begin(simulated, p, block=1024)
    assert isinstance(short, Run)
    assert_equal(consumed(short), alone(simulated, p, block=1024))


def test_a_failed_run_fails_again():
    wild = paper.mechanism(changes={"load.inertia": 1e-9})
    runs, simulated, p = SharedRuns(), simulator(wild), wild.kernel_values()
    true = alone(simulated, p)
    assert true[3] is not SimulationOutcome.COMPLETE
    consumed(runs.begin(simulated, p))
    assert_equal(consumed(runs.begin(simulated, p)), true)


def test_the_oldest_run_goes_first(mechanism):
    runs, simulated, p = SharedRuns(most=2 * BASE.samples), simulator(mechanism), mechanism.kernel_values()
    points = [p, 1.01 * p, 1.02 * p]
    for point in points:
        consumed(runs.begin(simulated, point))
    kept = [isinstance(runs.begin(simulated, point), KeptRun) for point in points]
    assert kept == [False, True, True]


def test_short_and_too_long_runs_are_not_kept(mechanism):
    p = mechanism.kernel_values()
    for runs, base in ((SharedRuns(), TimeBase(10_000.0, 500)), (SharedRuns(most=BASE.samples - 1), BASE)):
        simulated = simulator(mechanism, base=base)
        consumed(runs.begin(simulated, p))
        assert isinstance(runs.begin(simulated, p), Run)
