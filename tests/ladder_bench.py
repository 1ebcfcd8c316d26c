"""Where a search of one record stands whose mechanism as written follows a tenth of it, for tests of the ladder."""

from mechid.identification.computation.progress import silent
from mechid.identification.identify import make_problem
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import Growth
from mechid.identification.search.multistart import Candidate
from mechid.identification.stages.ladder import Climb
from mechid.identification.stages.watch import Watch
from synthetic import bench, displaced, truth

SAMPLES = 1001


def climb_of_one_record():
    """Return where a search of one record stands whose mechanism as written follows a tenth of it."""
    campaign = bench(displaced(truth(), {"gear.stiffness": 1.01}), truth(), "full_46", seed=5, seconds=0.1)
    problem = make_problem(campaign, 1)
    state = SearchState(problem, problem.start, problem.whole_windows())
    best = Candidate(problem.start, 100.0)
    return Climb(Watch(state, silent, 4), campaign, 1, state, best, growth=followed(problem.start, 100))


def followed(q, samples):
    return Growth(q, {"full_46": samples}, samples == SAMPLES, 3)
