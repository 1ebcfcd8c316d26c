"""Growth with effects beside a mechanism: which are kept. Truth: a hum and a harmonic that were added to records."""

import math

import numpy as np
import pytest

from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.identification.computation.progress import silent
from mechid.identification.effects.augmented import augment
from mechid.identification.effects.disturbance import Disturbance
from mechid.identification.effects.effect import AddedTerms
from mechid.identification.effects.settings import DURING_FIT
from mechid.identification.identify import make_problem
from mechid.identification.output_error.problem import transfer_values
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import Growth
from mechid.identification.search.solve import solve
from mechid.identification.stages.families import TERMS_AND_RECORDS, Families
from mechid.identification.stages.term_growth import (
    GrownModel,
    free_family_at_stall,
    select_needed_disturbances,
    settle,
    unfinished_state,
)
from mechid.identification.stages.watch import Watch
from synthetic import COMMANDS, NOISE_NM, RATE_HZ, TRUTH, bench, campaign, displaced, measured, record, truth

SECONDS = 0.3
HUM = Disturbance("mains:50Hz", "mains hum is in the records", lines_hz={"full_46": (50.0,)})


def with_hum(chi_square):
    """Return a record's problem, and how far it is followed with the lines of the mains projected out of a hum."""
    made_by = displaced(truth(), {"gear.stiffness": 1.0})
    torque = measured(made_by, COMMANDS["full_46"], np.random.default_rng((12, 1)), seconds=SECONDS)
    amplitude = NOISE_NM * math.sqrt(2.0 * chi_square / torque.size)
    torque = torque + amplitude * np.sin(2.0 * math.pi * 50.0 * np.arange(torque.size) / RATE_HZ)
    made = campaign(made_by.with_values(TRUTH), record("full_46", torque, COMMANDS["full_46"]))
    plain = make_problem(made, 1)
    model = augment(plain, AddedTerms(made.mechanism), None, (), (HUM,), "hum")
    growth = Growth(transfer_values(plain, plain.start, model.problem), {"full_46": torque.size}, True, 0)
    return plain, GrownModel(model, growth)


@pytest.mark.parametrize("chi_square", [0.0, 6.0, 14.0])
def test_a_hum_that_may_be_chance_is_not_named(chi_square):
    plain, reached = with_hum(chi_square)
    found, problem, q = select_needed_disturbances(reached)
    assert found == ()
    assert [t.leading.turns for t in problem.targets] == [t.leading.turns for t in plain.targets]
    assert problem.coordinates.names == plain.coordinates.names
    assert q.size == plain.size


def test_a_clear_hum_is_kept_with_what_it_explains():
    plain, reached = with_hum(200.0)
    (found,), problem, _ = select_needed_disturbances(reached)
    assert found.disturbance is HUM
    assert found.share == 1.0
    assert found.chi_square > DURING_FIT.least_chi_square
    assert found.chi_square == pytest.approx(200.0, abs=4.0 * 2.0 * math.sqrt(200.0)), "its scatter is 2 sqrt(chi2)"
    assert len(problem.targets[0].leading.turns) == len(plain.targets[0].leading.turns) + 1


HARMONIC, OTHER = "stepper.torque_harmonic:3", "stepper.imbalance"
FREE = ("gear.stiffness", "gear.damping")


def beside(*, amplitude):
    """Return a search of two records, whose mechanism may lack a harmonic, and the families of its effects."""
    harmonics = [{"order": 3, "amplitude": amplitude, "phase_deg": 40.0}]
    stepper = {**CATALOGUE["stepper"], **({"torque_harmonic": harmonics} if amplitude else {})}
    made_by = mechanism_from_table({**CATALOGUE, "stepper": stepper}, "made by").with_values(TRUTH)
    made = bench(truth().with_free(FREE), made_by, "full_46", "micro_46", seed=4, seconds=0.3)
    plain = make_problem(made, 1)
    state = SearchState(plain, plain.start, plain.whole_windows())
    return Watch(state, silent, 4), state, Families(plain, made)


def all_followed(model, q):
    return GrownModel(model, Growth(q, {t.name: t.samples for t in model.problem.targets}, True, 3))


@pytest.fixture(scope="module")
def lacking():
    return beside(amplitude=0.02)


def test_what_is_needed_where_a_growth_stalls_is_kept_alone(lacking):
    """Truth: the harmonic that made the records."""
    watch, state, families = lacking
    horizons = {t.name: t.samples // 2 for t in state.problem.targets}
    stalled = GrownModel(families.bare, Growth(state.q, horizons, False, 3))
    small = free_family_at_stall(watch, families, stalled, TERMS_AND_RECORDS)
    assert small.model.effects == (HARMONIC,)
    assert small.growth.horizons == horizons, "it has not been grown"
    assert small.share == pytest.approx(0.5, abs=1e-3)
    values = small.problem.coordinates.values(small.q)
    assert values["stepper.torque_harmonic.0.amplitude"] == pytest.approx(0.02, rel=0.05)


def test_records_are_settled_with_the_terms_that_they_need(lacking):
    """Truth: the harmonic that made the records; the other term and a delay of each record are none."""
    watch, state, families = lacking
    model = families.bare
    for name in (HARMONIC, OTHER, "record.delay"):
        model = families.with_effect(model, name)
    q = solve(model.problem, model.point_of(families.bare, state.q), model.problem.whole_windows(), steps=20).q
    settled, growth = settle(watch, state, all_followed(model, q), 1)
    assert settled.added.terms == (HARMONIC,)
    assert settled.added.widths == {}
    assert settled.found == ()
    assert growth.complete
    values = settled.problem.coordinates.values(growth.q)
    assert values.keys() == {*FREE, *settled.added.new}
    assert values["stepper.torque_harmonic.0.amplitude"] == pytest.approx(0.02, rel=0.05)


def test_nothing_is_added_to_a_mechanism_that_follows_all():
    """Truth: records of the mechanism as written, which a growth with a harmonic free follows too."""
    watch, state, families = beside(amplitude=0.0)
    model = families.with_effect(families.bare, HARMONIC)
    settled, growth = settle(watch, state, all_followed(model, model.point_of(families.bare, state.q)), 1)
    assert settled.added is None
    assert settled.problem.coordinates.names == state.problem.coordinates.names
    assert growth.complete


def test_what_has_not_arrived_is_a_state_with_its_effects(lacking):
    """Truth: the values of the growth, laid out as a mechanism file would declare them."""
    _, state, families = lacking
    model = families.with_effect(families.bare, HARMONIC)
    windows = {t.name: (0, t.samples // 2) for t in state.problem.targets}
    q = solve(model.problem, model.point_of(families.bare, state.q), windows, steps=20).q
    so_far = unfinished_state(
        state, GrownModel(model, Growth(q, {n: stop for n, (_, stop) in windows.items()}, False, 3))
    )
    assert so_far.added.terms == (HARMONIC,)
    assert "stepper.torque_harmonic.1.order" not in so_far.problem.space.mechanism.parameters
    before, after = model.problem.coordinates.values(q), so_far.problem.coordinates.values(so_far.q)
    assert after == pytest.approx({name: before[name] for name in after})
