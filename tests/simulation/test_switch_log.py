"""Where a run notes that its outputs jump: held against the run itself, sampled a thousand times as often."""

import numpy as np
import pytest

from layouts import LAYOUTS, changed, mechanism_of, paper_table
from mechid.simulation.batch import Batch
from mechid.simulation.simulator import Simulator, TimeBase
from paper import RECORDS

RATE_HZ = 1e4


def begun(mechanism, samples, *, rate_hz=RATE_HZ, **options):
    simulator = Simulator(mechanism.plant, RECORDS["full_46"], TimeBase(rate_hz, samples))
    return simulator.run(mechanism.kernel_values(), **options)


def jumps_of(blocks):
    """Return the noted samples, shares of an interval since, and rises of a run's first output, over all blocks."""
    found = [(b.start + b.jumps.samples, b.jumps.since, b.jumps.rises[:, 0]) for b in blocks if b.jumps.samples.size]
    return tuple(map(np.concatenate, zip(*found, strict=True)))


@pytest.fixture(scope="module")
def geared():
    return mechanism_of(changed(paper_table(), LAYOUTS["backlash"]))


def test_jumps_are_those_of_the_torque(geared):
    """Truth: the torque sampled each 0.1 us about each switch that the run logs."""
    logged = begun(geared, 1001, events=1000)
    list(logged.blocks())
    at, since, rises = jumps_of(begun(geared, 1001, events=None, block=100).blocks())
    gear = [switch.name for switch in geared.plant.switches].index("gear")
    times = logged.switching.time[logged.switching.switch == gear]
    np.testing.assert_array_equal(at, np.ceil(times * RATE_HZ - 1e-9))
    np.testing.assert_allclose(at - since, times * RATE_HZ, atol=1e-6)
    assert np.count_nonzero(np.abs(rises) > 1e-3) >= 5
    fine = begun(geared, 10001 * 100, rate_hz=1e7)
    y = np.concatenate([block.y[:, 0].copy() for block in fine.blocks()])
    for time, rise in zip(times, rises, strict=True):
        k = int(time * 1e7)
        if k + 3 < y.size:
            assert y[k + 3] - y[k - 1] == pytest.approx(rise, abs=1e-4)


@pytest.mark.slow
def test_a_batch_notes_what_each_of_its_runs_notes_alone(geared):
    """Truth: each run alone."""
    values = geared.kernel_values()
    stiffer = geared.with_values({"gear.stiffness": 1.1 * geared.value("gear.stiffness")}).kernel_values()
    simulator = Simulator(geared.plant, RECORDS["full_46"], TimeBase(RATE_HZ, 1001))
    sets = [values, stiffer, values]
    alone = [jumps_of(simulator.run(p, events=None).blocks()) for p in sets]
    each = Batch([simulator.run(p, events=None) for p in sets]).each()
    blocks = list(zip(*(one.blocks() for one in each), strict=True))
    for (at, since, rises), own in zip(alone, zip(*blocks, strict=True), strict=True):
        found = jumps_of(own)
        np.testing.assert_array_equal(found[0], at)
        np.testing.assert_allclose(found[1], since, atol=1e-6)
        np.testing.assert_allclose(found[2], rises, rtol=1e-6, atol=1e-12)


def test_a_torque_behind_a_flexible_housing_does_not_jump():
    """Truth: the paper's model, whose housing is moved by a torque that jumps and itself cannot: nothing is logged."""
    run = begun(mechanism_of(paper_table()), 1001, events=None)
    assert all(block.jumps.samples.size == 0 for block in run.blocks())
    assert run.buffers.events.size == 0


@pytest.mark.parametrize("other", [{"housing": None}, pytest.param(LAYOUTS["output_friction"], marks=pytest.mark.slow)])
def test_stick_and_slip_that_the_torque_shows_are_noted(other):
    """Truth: the switches that the run logs, and a torque that jumps at some of them."""
    mechanism = mechanism_of(changed(paper_table(), other))
    logged = begun(mechanism, 1001, events=1000)
    list(logged.blocks())
    at, _, rises = jumps_of(begun(mechanism, 1001, events=None).blocks())
    own = np.isin(logged.switching.switch, mechanism.plant.jump_switches)
    np.testing.assert_array_equal(at, np.ceil(logged.switching.time[own] * RATE_HZ - 1e-9))
    assert np.max(np.abs(rises)) > 1e-3
