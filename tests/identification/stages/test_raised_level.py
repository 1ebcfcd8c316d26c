"""The effect named at a raised noise level. Truth: the detent of 130 periods that made the records."""

import pytest

from detent_bench import AMPLITUDE_NM, PERIODS, detent_bench
from mechid.identification.computation.progress import silent
from mechid.identification.identify import make_problem
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import Growth
from mechid.identification.search.multistart import Candidate
from mechid.identification.stages.ladder import Climb
from mechid.identification.stages.raised_level import NAMED_AT_RAISED_LEVEL
from mechid.identification.stages.watch import Watch


@pytest.fixture(scope="module")
def after():
    """Return the climb after the rung, of records that the mechanism as written follows for 10 ms."""
    campaign = detent_bench(0.3)
    problem = make_problem(campaign, 1)
    state = SearchState(problem, problem.start, problem.whole_windows())
    growth = Growth(problem.start, {t.name: 100 for t in problem.targets}, False, 0)
    best = Candidate(problem.start, 100.0)
    return NAMED_AT_RAISED_LEVEL.attempt(Climb(Watch(state, silent, 4), campaign, 1, state, best, growth=growth))


@pytest.mark.slow
def test_the_effect_is_named_exactly_and_grown_to_the_ends(after):
    assert after.complete
    assert after.state.added.terms == (f"stepper.detent:{360.0 / PERIODS:.3g}deg",)
    amplitude = next(v for name, v in after.state.values.items() if name.endswith("detent.2.amplitude"))
    assert amplitude == pytest.approx(AMPLITUDE_NM, rel=0.02)


@pytest.mark.slow
def test_noise_levels_are_those_known_beforehand(after):
    at, _ = after.raised
    assert any(c.raised for t in at.problem.targets for c in t.channels)
    assert not any(c.raised for t in after.state.problem.targets for c in t.channels)
