"""Pruning of added terms. Truth: the mechanisms that made the records, each with one effect that the file lacks."""

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.identification.effects.effect import add_terms, share_kernel, substitute_law
from mechid.identification.effects.pruning import linearise
from mechid.identification.identify import make_problem
from mechid.identification.output_error.problem import transfer_values
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.solve import solve
from mechid.identification.stages.needed_terms import drop_unneeded_terms, exchanges
from mechid.plant.superset import rivals_of, superset_of
from synthetic import COMMANDS, TRUTH, campaign, measured, record

HARMONIC, DETENT, OFFSETS = "stepper.torque_harmonic:3", "stepper.detent:7.2deg", "stepper.phase_offset"
LIBRARY = (HARMONIC, DETENT, OFFSETS, "stepper.torque_harmonic:2", "gear.kinematic_error:2")
"""A small one, whose kernel takes a third of the time of the whole one to compile."""
EFFECTS = {
    HARMONIC: {"torque_harmonic": [{"order": 3, "amplitude": 0.03, "phase_deg": 40.0}]},
    DETENT: {"detent": [*CATALOGUE["stepper"]["detent"], {"period_deg": 7.2, "amplitude": 0.002, "phase_deg": 30.0}]},
}


def grown(name, only=LIBRARY):
    """Return the end of a growth with all terms of a library, each held small, and the problem as written."""
    made_by = mechanism_from_table({**CATALOGUE, "stepper": {**CATALOGUE["stepper"], **EFFECTS[name]}}, name)
    made_by = made_by.with_values(TRUTH)
    records = [
        record(n, measured(made_by, COMMANDS[n], np.random.default_rng((9, k)), seconds=0.3), COMMANDS[n])
        for k, n in enumerate(("full_46", "full_23", "micro_46"))
    ]
    made = campaign(catalogue_mechanism().with_values(TRUTH), *records)
    plain = make_problem(made, 2)
    superset = superset_of(made.mechanism, grown_only=True, only=only)
    added = add_terms(superset, [term.name for term in superset.terms])
    wide = share_kernel(added.problem(plain), superset)
    q = solve(wide, transfer_values(plain, plain.start, wide), wide.whole_windows(), steps=30, tolerance=1e-6).q
    return plain, SearchState(wide, q, wide.whole_windows(), added=added)


@pytest.fixture(scope="module")
def with_harmonic():
    return grown(HARMONIC)


def test_the_term_that_is_there_is_kept_alone_and_laid_out_first(with_harmonic):
    plain, state = with_harmonic
    found = drop_unneeded_terms(state, plain)
    assert found.added.terms == (HARMONIC,)
    assert found.added.widths == found.problem.shrinkage == {}
    assert set(found.added.new) == {f"stepper.torque_harmonic.0.{key}" for key in ("amplitude", "phase_deg")}
    assert "stepper.torque_harmonic.1.amplitude" not in found.problem.space.mechanism.parameters
    assert "gear.kinematic_error.0.amplitude" not in found.problem.space.mechanism.parameters
    values = found.values
    assert values["stepper.torque_harmonic.0.amplitude"] == pytest.approx(0.03, rel=0.05)
    samples = sum(t.samples for t in plain.targets)
    assert found.problem.total_norm(found.q, plain.whole_windows()) ** 2 < 1.05 * samples


def test_all_terms_stay_where_no_smaller_set_will_do(with_harmonic):
    plain, state = with_harmonic
    assert drop_unneeded_terms(state, plain, lambda *_: False) is state


def test_a_law_in_place_of_another_has_nothing_to_drop(with_harmonic):
    plain, _ = with_harmonic
    mechanism = plain.space.mechanism
    law = substitute_law(mechanism, next(iter(rivals_of(mechanism))))
    state = SearchState(law.problem(plain), law.problem(plain).start, plain.whole_windows(), added=law)
    assert drop_unneeded_terms(state, plain) is state


@pytest.mark.slow
def test_an_alias_is_tried_and_named():
    """Truth: offsets of the phase voltages and a detent of one period in a turn of the electrical angle are one."""
    plain, state = grown(DETENT, only=None)
    all_terms = linearise(state.problem, state.q, state.problem.whole_windows(), state.added.names_by_term)
    assert len(all_terms.needed_effects) == 1
    assert all_terms.needed_effects <= {DETENT, OFFSETS}
    assert {DETENT, OFFSETS} - all_terms.needed_effects in list(exchanges(all_terms, all_terms.needed_effects))
    found = drop_unneeded_terms(state, plain).added
    (kept,) = found.terms
    assert found.aliases == {kept: (({DETENT, OFFSETS} - {kept}).pop(),)}
