"""Steps of a search: a state in, the next one out; what describes a problem goes to another process."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from mechid.identification.computation.progress import silent
from mechid.identification.identify import make_problem
from mechid.identification.result.search_state import SearchState
from mechid.identification.stages.joint_fit import joint_fit
from mechid.identification.stages.watch import Watch
from synthetic import bench, displaced, truth

GEAR = ("gear.stiffness", "gear.damping")


@pytest.fixture(scope="module")
def state():
    """Return where a search for the gear begins, a tenth off."""
    made = bench(displaced(truth(), dict.fromkeys(GEAR, 1.1)), truth(), "full_46", seed=3, seconds=0.1)
    problem = make_problem(made, 1)
    return SearchState(problem, problem.start, problem.whole_windows())


def test_a_step_returns_the_next_state_and_leaves_its_own(state):
    """Truth: the state as it was; the truth that made the record, within five standard errors of a tenth."""
    before = state.q.copy()
    watch = Watch(state, silent, 1)
    after = joint_fit(watch, state, "joint fit", GEAR)
    np.testing.assert_array_equal(state.q, before)
    assert (state.stages, state.solution) == ((), None)
    assert [s.name for s in after.stages] == ["joint fit"]
    assert watch.latest is after
    assert after.has_converged
    for name in GEAR:
        assert after.values[name] == pytest.approx(truth().value(name), rel=0.05)


def test_an_interrupted_step_leaves_the_best_point_of_it(state):
    """Truth: its cost, simulated again, is below that of the start and is the least that was told of."""
    told = []

    def stop(progress):
        if progress.cost is not None:
            told.append(progress.cost)
        if len(told) == 4:
            raise KeyboardInterrupt

    watch = Watch(state, stop, 1)
    with pytest.raises(KeyboardInterrupt):
        joint_fit(watch, state, "joint fit", GEAR)
    costs = [state.problem.total_norm(q, state.windows) ** 2 for q in (watch.latest.q, state.q)]
    assert costs[0] < costs[1]
    assert costs[0] == pytest.approx(min(told[:-1]), rel=1e-9)


def test_seconds_of_stages_add_up_to_those_of_the_search(state):
    """Truth: the clock, which no time passes by between two stages."""
    watch = Watch(state, silent, 1)
    for number in range(3):
        state = watch.close(state, str(number), GEAR, 0.0, 0)
    assert sum(s.seconds for s in state.stages) == pytest.approx(watch.seconds, abs=0.1)
    assert all(s.seconds >= 0.0 for s in state.stages)
    assert state.stages[0].records == {"full_46": pytest.approx(0.1)}


def test_a_problem_that_has_run_goes_to_another_process(state):
    """Truth: the same numbers to the bit."""
    problem = replace(state.problem)
    triangle = problem.joint(state.q, state.windows)
    again = pickle.loads(pickle.dumps(problem))
    assert again.coordinates.names == problem.coordinates.names
    np.testing.assert_array_equal(again.joint(state.q, state.windows).jacobian, triangle.jacobian)
    assert again.norms(state.q, state.windows) == problem.norms(state.q, state.windows)
