"""What effects leave of the first moments. Truth: a detent of 130 periods that made the records."""

from dataclasses import replace

import numpy as np
import pytest

from detent_bench import detent_families, look_without_the_detent
from mechid.identification.computation.journal import Journal
from mechid.identification.stages import first_look
from mechid.identification.stages.families import TERMS_AND_RECORDS
from mechid.identification.stages.first_look import effect_words, first_windows, fit_look, prune_look
from mechid.identification.stages.settings import STAGES

RIGHT, WRONG = "stepper.detent:2.77deg", "stepper.torque_harmonic:3"


@pytest.fixture(scope="module")
def families():
    return detent_families()


@pytest.fixture(scope="module")
def plain(families):
    return look_without_the_detent(families)


def look_with(families, plain, *names):
    model = families.bare
    for name in names:
        model = families.with_effect(model, name)
    return fit_look(model, model.point_of(families.bare, plain.q), Journal())


def test_the_effect_that_is_missing_explains_the_first_moments(families, plain):
    """Truth: it leaves noise, 1 of a sample's; the mechanism as written and another effect many times that."""
    assert plain.samples == sum(stop - first for first, stop in first_windows(families.plain).values())
    assert not plain.explains
    right, wrong = look_with(families, plain, RIGHT), look_with(families, plain, WRONG)
    assert right.explains
    assert right.cost_per_sample == pytest.approx(1.0, abs=0.1)
    assert not wrong.explains
    assert wrong.cost_per_sample > 4.0
    assert right.criterion < wrong.criterion
    assert wrong.cost < plain.cost


def test_a_further_effect_has_to_be_worth_its_freedoms(families, plain):
    """Truth: Schwarz's criterion by hand: two more freedoms of an effect that is not there."""
    right, more = look_with(families, plain, RIGHT), look_with(families, plain, RIGHT, WRONG)
    assert more.model.problem.size == right.model.problem.size + 2
    assert more.criterion - right.criterion == pytest.approx(more.cost - right.cost + 2.0 * np.log(right.samples))
    assert right.criterion < more.criterion


def test_past_a_stall_nothing_is_fitted_again_where_nothing_is_dropped(families, plain, monkeypatch):
    """Truth: the look itself. Over the first moments, which cost little, it is fitted again."""
    right, windows = look_with(families, plain, RIGHT), first_windows(families.plain)
    fits = []
    monkeypatch.setattr(first_look, "fit_look", lambda model, q, *_: fits.append(q) or replace(right, model=model, q=q))
    past = prune_look(families, right, str, Journal(), windows)
    assert (past.model.effects, past.cost, len(fits)) == ((RIGHT,), right.cost, 0)
    assert prune_look(families, right, str, Journal()).model.effects == (RIGHT,)
    assert len(fits) == 1


def test_what_is_not_needed_is_dropped(families, plain):
    """Truth: the detent alone is missing."""
    wide = look_with(families, plain, RIGHT, WRONG, "record.delay")
    said = []
    less = prune_look(families, wide, said.append, Journal())
    assert less.model.effects == (RIGHT,)
    assert less.explains
    assert said[0].startswith(f"needed there: {RIGHT} (")
    bad = look_with(families, plain, WRONG)
    assert bad.cost_per_sample > STAGES.prunable
    assert prune_look(families, bad, said.append, Journal()) is bad, "which are needed cannot be told there"


def test_a_family_begins_where_it_is_and_explains_no_more_than_it_holds(families, plain):
    """Truth: no term of the usual ones is a detent of 130 periods."""
    model = families.model(TERMS_AND_RECORDS)
    wide = fit_look(model, model.point_of(families.bare, plain.q), Journal())
    assert wide.cost < plain.cost
    assert not wide.explains


def test_effects_are_said_with_what_they_explain():
    """Truth: by hand."""
    assert effect_words({"clock": 120.4, "mains:50Hz": 0.0}) == "clock (120), mains:50Hz"
    assert effect_words({}) == "none"


def test_what_explains_may_leave_more_than_the_noise_is_uncertain_by(families, plain):
    """Truth: costs a sample by hand, on both sides of either limit."""
    look = look_with(families, plain, RIGHT)
    for left, explains, surely in ((1.0, True, True), (1.07, True, False), (1.2, False, False)):
        one = replace(look, cost=left * look.samples)
        assert (one.explains, one.explains_surely) == (explains, surely)
