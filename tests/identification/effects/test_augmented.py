"""Models with effects free beside a mechanism. Truth: the mechanism itself, and a harmonic that made the record."""

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.identification.effects.augmented import augment
from mechid.identification.effects.campaign_disturbances import possible_disturbances
from mechid.identification.effects.effect import AddedTerms
from mechid.identification.identify import make_problem
from mechid.identification.search.solve import solve
from mechid.plant.superset import superset_of
from synthetic import COMMANDS, TRUTH, campaign, measured, record

HARMONIC, DETENT = "stepper.torque_harmonic:3", "stepper.detent:0.9deg"
LIBRARY = (HARMONIC, DETENT, "gear.kinematic_error:2")
"""A small one, whose kernel takes a third of the time of the whole one to compile."""
AMPLITUDE = 0.03
FREE = ("gear.stiffness", "gear.damping")


def with_three_effects(only):
    """Return the problem of a mechanism without the harmonic that made its record, and a model with three effects.

    `only` names the terms of its library; None is all.
    """
    stepper = {**CATALOGUE["stepper"], "torque_harmonic": [{"order": 3, "amplitude": AMPLITUDE, "phase_deg": 40.0}]}
    made_by = mechanism_from_table({**CATALOGUE, "stepper": stepper}, "with a harmonic").with_values(TRUTH)
    torque = measured(made_by, COMMANDS["full_46"], np.random.default_rng(5), seconds=0.2)
    own = campaign(
        catalogue_mechanism().with_values(TRUTH).with_free(FREE), record("full_46", torque, COMMANDS["full_46"])
    )
    plain = make_problem(own, 1)
    superset = superset_of(own.mechanism, grown_only=True, only=only)
    delay = next(one for one in possible_disturbances(plain, own) if one.name == "record.delay")
    model = augment(plain, AddedTerms(own.mechanism), superset, [HARMONIC, DETENT], [delay], "three effects")
    q = model.point_of(augment(plain, AddedTerms(own.mechanism), None, (), (), "as written"), plain.start)
    return plain, model, solve(model.problem, q, model.problem.whole_windows(), steps=30, tolerance=1e-6).q


@pytest.fixture(scope="module")
def made():
    return with_three_effects(LIBRARY)


def own_values(problem, q, model):
    """Return the values of the model's effects at a point, by name; 0 where the problem has them not."""
    values = problem.coordinates.values(q)
    return {n: values.get(n, 0.0) for names in model.names_by_effect.values() for n in names}


def test_a_point_of_less_is_where_the_further_effects_are_nothing(made):
    """Truth: the simulation of the mechanism without them."""
    plain, model, _ = made
    assert model.effects == (HARMONIC, DETENT, "record.delay")
    bare = model.keep_effects(plain, (), "as written")
    assert bare.effects == ()
    q = model.point_of(bare, bare.problem.start)
    assert set(own_values(model.problem, q, model).values()) == {0.0}
    whole = plain.whole_windows()
    cost = model.problem.total_norm(q, whole)
    assert cost == pytest.approx(plain.total_norm(plain.start, whole), rel=1e-9)


def test_what_is_kept_is_where_it_was(made):
    """Truth: the values of the model with all three effects."""
    plain, model, q = made
    less = model.keep_effects(plain, [HARMONIC], "one effect")
    assert (less.name, less.effects, less.disturbances) == ("one effect", (HARMONIC,), ())
    assert less.added.widths.keys() < model.added.widths.keys()
    there = less.problem.coordinates.values(less.point_of(model, q))
    values = model.problem.coordinates.values(q)
    assert there == pytest.approx({name: values[name] for name in there})
    assert set(there) == {*FREE, *less.names_by_effect[HARMONIC]}
    assert less.problem.space.mechanism.plant is model.problem.space.mechanism.plant, "nothing is compiled anew"


def test_the_effect_that_made_the_record_is_needed_alone(made):
    """Truth: the harmonic; the rise without it is what a fit of the mechanism as written leaves more, roughly: by
    derivatives where there are 23,000 sigmas squared of it."""
    plain, model, q = made
    whole = plain.whole_windows()
    found = model.needed_effects(q, whole)
    assert list(found) == [HARMONIC]
    cost = model.problem.total_norm(q, whole) ** 2
    without = plain.total_norm(solve(plain, plain.start, whole, steps=20).q, whole) ** 2
    assert found[HARMONIC] == pytest.approx(without - cost, rel=0.2)


def test_a_prior_becomes_wider_where_its_term_stands_at_the_edge(made):
    """Truth: the widths by hand: one term at 3 widths, the other within its own."""
    plain, model, q = made
    values = model.problem.coordinates.values(q)
    (name,) = {n for n in model.names_by_effect[HARMONIC] if n.endswith("amplitude")}
    at_edge = model.problem.coordinates.point({**values, name: 3.0 * model.added.widths[name]})
    wider = model.widen_priors(plain, at_edge, 2.0, 4.0)
    (other,) = model.added.widths.keys() - {name}
    assert wider.added.widths == {name: 4.0 * model.added.widths[name], other: model.added.widths[other]}
    assert wider.problem.shrinkage == wider.added.widths
    assert model.widen_priors(plain, at_edge, 3.5, 4.0) is model
    assert plain.shrinkage == {}


def test_a_prior_becomes_wider_where_a_value_of_a_record_stands_at_the_edge(made):
    """Truth: the widths by hand: a delay at 3 of its deviations; the terms stay as they are."""
    plain, model, q = made
    values = model.problem.coordinates.values(q)
    (delay,) = model.disturbances[0].parameters
    at_edge = model.problem.coordinates.point({**values, delay.name: 3.0 * delay.sigma})
    wider = model.widen_priors(plain, at_edge, 2.0, 4.0)
    (found,) = wider.disturbances[0].parameters
    assert found.sigma == pytest.approx(4.0 * delay.sigma)
    assert wider.problem.priors[delay.name] == (delay.value, found.sigma)
    assert wider.added.widths == model.added.widths
    np.testing.assert_allclose(wider.point_of(model, at_edge), at_edge)
    assert model.widen_priors(plain, at_edge, 3.5, 4.0) is model


@pytest.mark.slow
def test_a_model_laid_out_has_the_same_residual_and_no_place_for_others():
    """Truth: the same effects on the plant of all terms, at the same values; the parameters of its plant by count."""
    plain, model, q = with_three_effects(None)
    compact = model.lay_out(plain)
    there = compact.point_of(model, q)
    whole = model.problem.whole_windows()
    assert compact.effects == model.effects
    assert compact.problem.total_norm(there, whole) == pytest.approx(model.problem.total_norm(q, whole), rel=1e-9)
    assert model.point_of(compact, there) == pytest.approx(q, rel=1e-9)
    wide, small = (len(m.problem.space.mechanism.plant.parameters) for m in (model, compact))
    assert small < 0.6 * wide
    fewer = compact.keep_effects(plain, {DETENT, "record.delay"}, "two")
    assert set(fewer.effects) == {DETENT, "record.delay"}
    moved = fewer.problem.coordinates.values(fewer.point_of(compact, there))
    kept = compact.problem.coordinates.values(there)
    names = zip(fewer.added.names_by_term[DETENT], compact.added.names_by_term[DETENT], strict=True)
    assert all(moved[one] == pytest.approx(kept[other], rel=1e-9) for one, other in names)
