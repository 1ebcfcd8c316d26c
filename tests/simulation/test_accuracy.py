"""As many steps as the promise needs; truth: many more steps, and closed expectations of failure."""

import numpy as np
import pytest

import paper
from mechid.simulation.accuracy import ENOUGH, PROMISE, simulate_accurately
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
from mechid.simulation.trajectory import SimulationOutcome

BASE = TimeBase(10_000.0, 3001)


def simulator(mechanism, name="full_46", base=BASE):
    return Simulator(mechanism.plant, paper.RECORDS[name], base)


@pytest.mark.parametrize("name", ["full_5", "full_23", "full_46", "full_92", "micro_46"])
def test_the_error_is_within_the_promise(name):
    mechanism = paper.mechanism()
    run = simulator(mechanism, name)
    trajectory = simulate_accurately(run, mechanism.kernel_values())
    fine = simulate_run(run.run(mechanism.kernel_values(), substeps=32))
    error = np.linalg.norm(trajectory.torque - fine.torque) / np.linalg.norm(fine.torque)
    assert error <= 0.1 * PROMISE
    assert trajectory.difference is not None
    assert error <= trajectory.difference <= ENOUGH


def test_a_slow_sampling_takes_more_steps():
    mechanism = paper.mechanism()
    slow = simulate_accurately(simulator(mechanism, base=TimeBase(1000.0, 301)), mechanism.kernel_values())
    fast = simulate_accurately(simulator(mechanism), mechanism.kernel_values())
    assert slow.substeps > fast.substeps


def test_a_mechanism_that_diverges_keeps_its_shape_and_says_when():
    mechanism = paper.mechanism(changes={"load.inertia": 1e-9})
    trajectory = simulate_accurately(simulator(mechanism), mechanism.kernel_values())
    lost = np.flatnonzero(np.isnan(trajectory.torque))
    assert trajectory.outcome is not SimulationOutcome.COMPLETE
    assert trajectory.torque.shape == (BASE.samples,)
    assert trajectory.difference is None
    assert trajectory.lost_from_s == pytest.approx(lost[0] / BASE.sample_rate_hz)
    assert lost[-1] == BASE.samples - 1


def test_a_mechanism_at_rest_differs_by_nothing():
    mechanism = paper.mechanism(changes={"stepper.detent.0.amplitude": 0.0, "stepper.detent.1.amplitude": 0.0})
    resting = Simulator(mechanism.plant, paper.constant(0.0, start_angle_deg=0.0), BASE)
    trajectory = simulate_accurately(resting, mechanism.kernel_values())
    assert not trajectory.torque.any()
    assert trajectory.difference == 0.0
    assert trajectory.lost_from_s is None
