"""The time loop of a batch, which a set leaves where something else than flowing happens. Truth: each run alone."""

import numpy as np
import pytest

from golden_variants import VARIANTS
from layouts import LAYOUTS, changed, mechanism_of, paper_table
from mechid.command import Timing
from mechid.simulation.batch import SETS, Batch
from mechid.simulation.simulator import Simulator
from mechid.simulation.switch_log import concatenate_jumps
from mechid.simulation.trajectory import SimulationOutcome
from side_by_side import BASE, FULL, MICRO, alone, around, begun, together


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
        return concatenate_jumps([block.jumps.shift_by(block.start) for block in run.blocks()])

    together = [[] for _ in points]
    for blocks in zip(*(run.blocks() for run in Batch(runs()).each()), strict=True):
        for found, block in zip(together, blocks, strict=True):
            found.append(block.jumps.shift_by(block.start))
    for expected, found in zip(map(noted, runs()), map(concatenate_jumps, together), strict=True):
        assert expected.samples.size > 4
        np.testing.assert_array_equal(found.samples, expected.samples)
        np.testing.assert_allclose(found.since, expected.since, atol=1e-5)
        np.testing.assert_allclose(found.rises, expected.rises, rtol=1e-6, atol=1e-9)


@pytest.fixture(scope="module")
def paper():
    """The paper's mechanism."""
    return mechanism_of(VARIANTS["paper"])


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
