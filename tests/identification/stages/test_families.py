"""Families of effects as models of one problem. Truth: a detent of 130 periods that made the records."""

from dataclasses import replace

import pytest

from detent_bench import AMPLITUDE_NM, FREE, PERIODS, detent_bench
from mechid.identification.effects.effect import AddedTerms
from mechid.identification.identify import make_problem
from mechid.identification.search.solve import solve
from mechid.identification.stages.families import EVERYTHING, RECORDS, TERMS, TERMS_AND_RECORDS, Families

RIGHT = "stepper.detent:2.77deg"


@pytest.fixture(scope="module")
def families():
    campaign = detent_bench()
    return Families(make_problem(campaign, 1), campaign)


def test_a_family_has_what_it_says(families):
    """Truth: the kinds by hand; every family has the mechanism's parameters too; those with terms are one plant."""
    of_records = {"clock", "record.delay", "record.voltage", "record.gain"}
    assert families.bare.effects == ()
    assert set(families.model(RECORDS).effects) == of_records, "gains too, although the file has no transducer"
    usual = set(families.model(TERMS).effects)
    assert {"stepper.torque_harmonic:3", "stepper.phase_offset", "gear.kinematic_error:4"} <= usual
    assert not any(name in families.unlisted_terms for name in usual)
    assert set(families.model(TERMS_AND_RECORDS).effects) == usual | of_records
    rarer = set(families.model(EVERYTHING).effects) - usual - of_records
    assert {"stepper.detent:1.2deg", "gear.kinematic_error:7"} <= rarer
    plants = {id(families.model(one).problem.space.mechanism.plant) for one in (TERMS, TERMS_AND_RECORDS, EVERYTHING)}
    assert len(plants) == 1
    places = families.model(RECORDS).problem.space.mechanism.parameters.keys()
    assert places == {*families.plain.space.mechanism.parameters, "transducer.gain"}, "no place for terms"
    assert {c.name for c in families.bare.problem.space.coordinates} == set(FREE)


def test_another_number_of_periods_takes_the_place_of_one(families):
    """Truth: a fit with the right number, which ends at the detent that made the records."""
    other = families.with_periods(RIGHT, PERIODS - 1)
    model, moved = families.with_other_term(families.with_effect(families.bare, other), other, RIGHT)
    assert families.periods(RIGHT) == PERIODS
    assert model.effects == (RIGHT,)
    assert model.name == RIGHT
    amplitude = next(name for name in moved.values() if name.endswith("amplitude"))
    whole = model.problem.whole_windows()
    q = solve(model.problem, model.point_of(families.bare, families.plain.start), whole, steps=30).q
    assert model.problem.coordinates.values(q)[amplitude] == pytest.approx(AMPLITUDE_NM, rel=0.1)
    wrong = families.with_effect(families.bare, families.with_periods(RIGHT, 90))
    less = solve(wrong.problem, wrong.point_of(families.bare, families.plain.start), whole, steps=30).q
    assert wrong.problem.total_norm(less, whole) > 1.5 * model.problem.total_norm(q, whole)


def test_a_law_stands_beside_the_effects_of_a_model(families):
    """Truth: the parameters of both, by name."""
    model = families.with_effect(families.bare, "stepper.torque_harmonic:3")
    law = next(one for one in families.laws() if one.name == "anti_alias:4")
    both = families.model_with_law(law, model)
    assert both.effects == ("anti_alias:4", "stepper.torque_harmonic:3")
    assert both.added.law == "anti_alias:4"
    assert both.added.terms == ("stepper.torque_harmonic:3",)
    assert {"anti_alias.frequency", "stepper.torque_harmonic.0.amplitude"} <= both.added.new.keys()
    assert families.model_with_law(law).effects == ("anti_alias:4",)


def test_nothing_is_added_where_the_campaign_wants_none(families):
    """Truth: [identify] terms = false and disturbances = "none"."""
    options = replace(families.campaign.options, terms=False, disturbances="none")
    none = Families(families.plain, replace(families.campaign, options=options))
    assert none.model(EVERYTHING).effects == ()
    assert list(none.laws()) == []
    assert none.base == AddedTerms(families.plain.space.mechanism)


def test_friction_over_one_angle_has_a_counterpart_over_the_other(families):
    """Truth: the gear's ratio: k periods a turn of the rotor are k times the ratio of the output, where listed."""
    ratio = families.plain.space.mechanism.value("gear.ratio")
    name = families.counterpart("friction.position:1")
    assert name == f"friction.position:output:{round(ratio)}"
    assert families.counterpart(name) == "friction.position:1"
    assert families.counterpart(RIGHT) is None, "a detent"
    assert families.counterpart("friction.position:8") is None, "more than 100 a turn of the output"
