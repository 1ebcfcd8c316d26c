"""The ladder of a search. Truth: rungs made by hand, and a bench of which the mechanism file lacks one effect."""

from dataclasses import replace

import numpy as np
import pytest

from ladder_bench import SAMPLES, climb_of_one_record, followed
from mechid.identification.effects.augmented import AugmentedModel
from mechid.identification.identify import identify
from mechid.identification.search.first_moments import first_samples
from mechid.identification.search.multistart import Candidate
from mechid.identification.stages import ladder
from mechid.identification.stages.budget import complete_work, effects_budget, ladder_budget
from mechid.identification.stages.ladder import Rung, climb_ladder
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.term_growth import GrownModel, grow_model
from mechid.identification.stages.watch import Watch
from mechid.simulation.work import count, work_counter


@pytest.fixture(scope="module")
def climb():
    return climb_of_one_record()


def to(samples):
    """Return an attempt that comes so far with the mechanism as written."""
    return lambda climb: replace(climb, growth=followed(climb.best.q, samples))


def test_rungs_are_tried_in_order_until_all_is_followed(climb):
    """Truth: by hand. What does not apply is not tried, and nothing after the one that arrives."""
    rungs = (
        Rung("first", lambda _: True, to(200)),
        Rung("of no use", lambda _: False, to(SAMPLES)),
        Rung("second, from the first", lambda climb: climb.growth.horizons["full_46"] == 200, to(SAMPLES)),
        Rung("never", lambda _: True, to(0)),
    )
    told = []
    watch = Watch(climb.state, told.append, 4)
    end = climb_ladder(replace(climb, watch=watch), rungs)
    assert end.complete
    assert end.tried == ("first", "second, from the first")
    assert climb.tried == ()
    said = [one.line for one in told if one.stage == "ladder"]
    assert said == ["rung 1 of 4: first", "rung 3 of 4: second, from the first"]


def test_a_ladder_that_does_not_arrive_has_tried_every_rung(climb):
    rungs = tuple(Rung(name, lambda _: True, lambda climb: climb) for name in ("one", "two"))
    end = climb_ladder(replace(climb, tried=("as written",)), rungs)
    assert not end.complete
    assert end.tried == ("as written", "one", "two")


def test_nothing_is_tried_where_all_is_followed_already(climb):
    done = replace(climb, growth=followed(climb.best.q, SAMPLES))
    assert climb_ladder(done, (Rung("one", lambda _: True, to(0)),)) is done


def test_the_furthest_growth_is_kept(climb):
    """Truth: shares by hand; a rung that comes less far changes nothing."""
    model = climb.families.bare
    far, near = (GrownModel(model, followed(climb.best.q, n)) for n in (700, 300))
    at = climb.with_growth(far)
    assert at.reached is far
    assert at.with_growth(near).reached is far
    assert at.growth is climb.growth, "that of the mechanism as written, until a rung has followed all"
    assert climb.with_growth(near).with_growth(far).reached is far


def test_a_growth_that_follows_all_records_is_settled(climb, monkeypatch):
    """Truth: what settling returns, or refuses."""
    complete = GrownModel(climb.families.bare, followed(climb.best.q, SAMPLES))
    settled = replace(climb.state, warnings=("settled",))
    monkeypatch.setattr(ladder, "settle", lambda _watch, _state, reached, _seed: (settled, reached.growth))
    end = climb.with_growth(complete)
    assert end.complete
    assert end.state is settled
    monkeypatch.setattr(ladder, "settle", lambda *_: None)
    refused = climb.with_growth(complete)
    assert not refused.complete
    assert refused.state is climb.state
    assert refused.reached is complete


def test_what_explains_the_first_moments_is_told_by_the_cost_a_sample(climb):
    """Truth: a tenth more than noise, by hand."""
    samples = first_samples(climb.state.problem.targets[0])
    for over_noise, explained in ((1.05, True), (1.2, False)):
        best = Candidate(climb.best.q, over_noise * samples)
        assert replace(climb, best=best).is_explained is explained


def test_models_of_a_climb_are_of_its_records(climb):
    """Truth: the problem of the mechanism as written."""
    bare = climb.families.bare
    assert isinstance(bare, AugmentedModel)
    np.testing.assert_array_equal(bare.problem.start, climb.state.problem.start)


def test_a_rung_ends_at_its_budget_and_the_next_is_not_tried(climb):
    """Truth: work by hand; what was grown before is kept, and the rung without a budget is tried all the same."""

    def work(units):
        def attempt(one):
            one = replace(one, looks=(*one.looks, units))
            count(units)
            return one

        return attempt

    rungs = (
        Rung("cheap", lambda _: True, work(6), lambda _: 10),
        Rung("dear", lambda _: True, work(7), lambda _: 10),
        Rung("for effects", lambda _: True, work(1), lambda _: 10),
        Rung("for readings", lambda _: True, work(1), lambda _: 20),
        Rung("in any case", lambda _: True, work(100)),
    )
    end = climb_ladder(climb, rungs)
    assert end.tried == ("cheap", "dear", "for readings", "in any case")
    assert end.looks == (6, 1, 100), "of the one that was cut off nothing is kept that it had not returned"
    assert end.state.warnings == (*climb.state.warnings, ladder.BUDGET_SPENT)
    assert ladder.BUDGET_SPENT not in climb_ladder(climb, rungs[:1]).state.warnings
    arrives = Rung("arrives", lambda _: True, to(SAMPLES), lambda _: 20)
    assert ladder.BUDGET_SPENT not in climb_ladder(climb, (rungs[0], rungs[1], arrives)).state.warnings


def test_a_growth_that_its_budget_ends_keeps_how_far_it_came(climb):
    """Truth: a growth of a third of the work that the whole one takes."""
    model = climb.families.bare
    with work_counter() as whole:
        grow_model(climb.watch, model, climb.best.q, 1)
    with work_counter(limit=whole.done // 3):
        cut = grow_model(climb.watch, model, climb.best.q, 1)
    assert not cut.growth.complete
    assert 0.0 < cut.share < 1.0
    with work_counter(limit=0):
        none = grow_model(climb.watch, model, climb.best.q, 1)
    np.testing.assert_array_equal(none.q, climb.best.q)


def test_the_budget_is_that_of_a_complete_campaign_of_the_same_records(climb):
    """Truth: an identification that lacks nothing, within a factor of two."""
    problem = climb.state.problem
    with work_counter() as work:
        assert identify(climb.campaign, workers=1).grade.good
    assert 0.5 < work.done / complete_work(problem) < 2.0
    assert effects_budget(problem) < ladder_budget(problem) == STAGES.ladder_budget * complete_work(problem)
