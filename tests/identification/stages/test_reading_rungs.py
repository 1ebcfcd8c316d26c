"""Rungs for records that are not as declared. Truth: a torque that no mechanism explains, and starts made by hand."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.identification.computation.progress import silent
from mechid.identification.identify import make_problem
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import Growth, grow_horizons
from mechid.identification.search.multistart import Candidate
from mechid.identification.stages import reading_rungs
from mechid.identification.stages.ladder import Climb, climb_ladder
from mechid.identification.stages.reading_rungs import READINGS, grow_at_raised_noise
from mechid.identification.stages.watch import Watch
from synthetic import NOISE_NM, bench, displaced, truth, with_leading

STIFFNESS = "gear.stiffness"
SAMPLES = 2001


def climb_of(further):
    """Return a search of one record with further torque, and its growth from the truth."""
    campaign = bench(displaced(truth(), {STIFFNESS: 1.0}), truth(), "full_46", seed=5, seconds=0.2)
    problem = make_problem(campaign, 1)
    (target,) = problem.targets
    torque = np.array(target.leading.measured) + further
    problem = replace(problem, targets=(with_leading(target, measured=torque),))
    growth = grow_horizons(problem, problem.start, np.random.default_rng(1), escapes=0)
    state = SearchState(problem, problem.start, problem.whole_windows())
    return Climb(Watch(state, silent, 4), campaign, 1, state, Candidate(problem.start, 1e6), growth=growth)


@pytest.fixture
def restless(monkeypatch):
    """Return a search whose record trembles by twenty times its noise, and let starts anew be the truth alone."""
    tremor = 20.0 * NOISE_NM * np.sin(np.arange(SAMPLES) ** 1.5 / 40.0)
    climb = climb_of(tremor)
    start = Candidate(climb.state.problem.start, 1e6)
    monkeypatch.setattr(reading_rungs, "refine_starts", lambda *_: iter([start]))
    return climb


def test_a_level_is_raised_until_the_record_is_followed(restless):
    """Truth: a tremor of 20 times the noise, RMS 14 times; nothing of the mechanism makes it."""
    assert not restless.complete
    (before,) = (c.sigma for t in restless.state.problem.targets for c in t.channels)
    at, growth = grow_at_raised_noise(restless.watch, restless.state, restless.growth, 1)
    assert growth.complete
    (channel,) = (c for t in at.problem.targets for c in t.channels)
    assert channel.raised
    assert channel.sigma > before
    assert "the model follows it for" in at.before_raised["full_46"], "what stopped it before is said"
    found = at.problem.coordinates.values(growth.q)[STIFFNESS]
    assert found == pytest.approx(truth().value(STIFFNESS), rel=0.02)


def test_what_is_followed_needs_no_raised_level():
    """Truth: a record of the mechanism: state and growth are as they were."""
    climb = climb_of(0.0)
    assert climb.complete
    at, growth = grow_at_raised_noise(climb.watch, climb.state, climb.growth, 1)
    assert (at, growth) == (climb.state, climb.growth)
    assert climb_ladder(climb, READINGS) is climb


def test_a_raised_level_is_noted_beside_the_search(restless):
    """Truth: the state stays that of the levels known; the rungs behind begin from the raised one."""
    raised = READINGS[0].attempt(restless)
    assert raised.state is restless.state
    assert not raised.complete
    assert raised.state_at_raised_noise[1].complete
    assert restless.state_at_raised_noise == (restless.state, restless.growth)
    alone = READINGS[1].attempt(raised)
    assert alone is raised, "of one record none is left to say how it is to be read"
    assert READINGS[2].attempt(restless) is restless, "nothing was raised"


def test_other_starts_are_grown_where_nothing_contradicts(monkeypatch):
    """Truth: the third start, which is the mechanism's; the best one leads nowhere."""
    climb = climb_of(0.0)
    problem = climb.state.problem
    far, right = problem.coordinates.lower, problem.start
    stalled = Growth(far, {"full_46": 150}, False, 3)
    monkeypatch.setattr(reading_rungs, "agreement", lambda *_, **__: None)
    monkeypatch.setattr(reading_rungs, "find_wrong_values", lambda *_: [])
    monkeypatch.setattr(reading_rungs, "common_readings", lambda *_: [])
    one = replace(climb, growth=stalled, found=iter([Candidate(right, 10.0)]))
    end = climb_ladder(one, READINGS[-1:])
    assert end.complete
    assert end.tried == ("records compared, other starts",)
    none = climb_ladder(replace(one, found=iter(())), READINGS[-1:])
    assert not none.complete
    assert none.growth is stalled


def test_a_value_that_is_wrong_by_a_hundred_is_said_and_nothing_else_tried(monkeypatch):
    """Truth: a finding made by hand."""

    class Wrong:
        parameter, text = "gear.ratio", "gear.ratio = 5000 leaves all records; 50 follows them"

    climb = replace(climb_of(0.0), growth=Growth(np.zeros(1), {"full_46": 150}, False, 3), found=iter(()))
    monkeypatch.setattr(reading_rungs, "agreement", lambda *_, **__: None)
    monkeypatch.setattr(reading_rungs, "find_wrong_values", lambda *_: [Wrong])
    end = READINGS[-1].attempt(climb)
    assert end.state.contradicted == {Wrong.parameter: Wrong.text}
    assert end.growth is climb.growth
