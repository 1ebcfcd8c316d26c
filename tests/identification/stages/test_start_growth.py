"""Growth from the best starts, several at once where workers do the work."""

import numpy as np

import chores
import synthetic
from mechid.identification.computation.progress import silent
from mechid.identification.computation.workforce import working_on
from mechid.identification.identify import make_problem
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import Growth
from mechid.identification.search.multistart import Candidate, multistart
from mechid.identification.search.settings import SEARCH
from mechid.identification.stages.start_growth import grow_starts, refine_more_starts
from mechid.identification.stages.watch import Watch


def test_candidates_are_grown_at_once_and_count_in_their_order(monkeypatch):
    """Truth: one after the other here. The third follows all records first, whatever the later ones do."""
    campaign = synthetic.bench(synthetic.truth(), synthetic.truth(), "full_46", seed=5, seconds=0.1)
    problem = make_problem(campaign, 1)
    state = SearchState(problem, problem.start, problem.whole_windows())
    grown = []

    def grow(problem, q, rng, *_, **__):
        number = round(float(q[0]))
        grown.append(number)
        followed = {1: 300, 2: 500, 3: 1001, 4: 1001, 5: 100}[number]
        return Growth(q + rng.standard_normal(), {"full_46": followed}, followed == 1001, number)

    monkeypatch.setattr("mechid.identification.stages.start_growth.grow_horizons", grow)
    starts = [Candidate(np.full(problem.size, float(number)), 0.0) for number in range(1, 6)]
    here = grow_starts(Watch(state, silent, 4), state, iter(starts), 7)
    assert grown == [1, 2, 3]
    with working_on(chores.Recorded(2)):
        there = grow_starts(Watch(state, silent, 4), state, iter(starts), 7)
    assert grown == [1, 2, 3, 1, 2, 3, 4]
    assert (there.q.tobytes(), there.horizons, there.complete) == (here.q.tobytes(), here.horizons, True)


def test_more_starts_are_those_behind_the_usual_ones(monkeypatch):
    """Truth: the ranking of all points by cost; of the longer ranking the usual starts are the first."""
    campaign = synthetic.bench(synthetic.truth(), synthetic.truth(), "full_46", seed=5, seconds=0.1)
    problem = make_problem(campaign, 1)
    state = SearchState(problem, problem.start, problem.whole_windows())
    usual, ranked = (multistart(problem, 0, 1, starts=n) for n in (SEARCH.starts, SEARCH.more_starts))
    assert [one.cost for one in ranked[: SEARCH.starts]] == [one.cost for one in usual]
    assert len(ranked) == SEARCH.more_starts
    refined = []

    def refine(_problem, starts, *_):
        refined.extend(starts)
        return iter(starts)

    monkeypatch.setattr("mechid.identification.stages.start_growth.candidates", refine)
    found = refine_more_starts(Watch(state, silent, 4), state, 0)
    assert [one.cost for one in refined] == [one.cost for one in ranked[SEARCH.starts :]]
    assert found.cost == refined[0].cost
