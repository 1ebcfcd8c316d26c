"""The order in which starts are tried, where the first moments tell nothing of them."""

from dataclasses import replace

import numpy as np
import pytest

from complete_fits import CASES
from mechid.identification.identify import make_problem
from mechid.identification.search.box import sample_box
from mechid.identification.search.multistart import candidates, capped_costs, multistart
from mechid.identification.search.settings import SEARCH
from synthetic import COMMANDS, campaign, measured, record, truth


@pytest.fixture(scope="module")
def quiet_problem(tmp_path_factory):
    """Return a problem whose records are so noisy that all starts explain them alike."""
    problem = make_problem(CASES["direct_torque_drive"].campaign(tmp_path_factory.mktemp("quiet")), 1)
    quiet = tuple(t.map_channels(lambda channel: replace(channel, sigma=1e6 * channel.sigma)) for t in problem.targets)
    return replace(problem, targets=quiet)


@pytest.mark.parametrize("seed", [0, 1])
def test_starts_that_explain_nothing_better_are_tried_as_drawn_the_catalogue_first(quiet_problem, seed):
    """Truth: the sequence itself. All costs are 1e-12 of a start that is wrong, and differ by less than counts."""
    starts = multistart(quiet_problem, seed, 1)
    assert 0.0 < np.ptp([start.cost for start in starts]) < 1e-3
    drawn = sample_box(quiet_problem.space, SEARCH.starts, seed)
    np.testing.assert_array_equal([start.q[: quiet_problem.space.size] for start in starts], drawn)
    first = next(iter(candidates(quiet_problem, starts, 1)))
    np.testing.assert_array_equal(first.q, quiet_problem.start)


def test_starts_that_explain_better_come_first(tmp_path):
    """Truth: the costs, in order; none is worse than the next by more than counts."""
    problem = make_problem(CASES["direct_torque_drive"].campaign(tmp_path), 1)
    costs = [start.cost for start in multistart(problem, 0, 1)]
    assert np.all(np.diff(costs) > -1e-3)
    assert costs[0] < capped_costs(problem, [problem.start], targets=problem.targets)[0]


def test_a_start_that_cannot_rest_is_dropped_and_costs_no_other():
    """Truth: each start by itself; a detent of nearly half the holding torque leaves nothing that rests near by."""
    command = replace(COMMANDS["full_46"], start="equilibrium")
    y = measured(truth(), command, np.random.default_rng(1), seconds=0.2)
    problem = make_problem(campaign(truth(), record("full_46", y, command)), 1)
    values = problem.coordinates.values(problem.start)
    lost = {"stepper.detent.0.amplitude": 0.1, "stepper.detent.0.phase_deg": 50.0, "stepper.detent.1.amplitude": 0.0}
    points = [problem.start] * 4 + [problem.coordinates.point({**values, **lost})] + [problem.start] * 3
    costs = capped_costs(problem, points, targets=problem.targets)
    assert costs[4] == np.inf
    alone = capped_costs(problem, [problem.start], targets=problem.targets)[0]
    assert np.delete(costs, 4) == pytest.approx(alone, rel=1e-9)
