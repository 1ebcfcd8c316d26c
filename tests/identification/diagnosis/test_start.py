"""Where a diagnosis begins. Truth: the mechanism file, and what the fit has held."""

from dataclasses import replace

import pytest

from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.identification.conclude import conclude
from mechid.identification.diagnosis.start import initial_models
from mechid.identification.effects.effect import lay_out, substitute_law
from mechid.identification.identify import make_problem
from mechid.identification.result.grade import FitOutcome, Grade
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.solve import solve
from mechid.plant.superset import rivals_of
from synthetic import TRUTH, bench, displaced, truth


def test_a_fit_on_a_wrong_branch_holds_no_parameter(fitted):
    """Truth: the mechanism file, which says what is free; the fit has held one of these."""
    bench, fit = fitted
    held = replace(fit.parameters["gear.damping"], status="frozen")
    fit = replace(fit, parameters={**fit.parameters, "gear.damping": held})

    def free(grade):
        return {p.name for p in initial_models(replace(fit, grade=grade))[0].base.free}

    assert free(Grade.C) == {p.name for p in bench.mechanism.free}
    assert free(Grade.C) - free(Grade.B) == {"gear.damping"}


@pytest.mark.slow
def test_a_diagnosis_begins_with_a_law_and_the_terms_beside_it():
    """Truth: a low-pass and a harmonic that made the record; the fit has found both."""
    law, term, frequency = "anti_alias:2", "stepper.torque_harmonic:3", 12e3
    table = {**CATALOGUE, "anti_alias": {"order": 2, "frequency": frequency}}
    table["stepper"] = {**CATALOGUE["stepper"], "torque_harmonic": [{"order": 3, "amplitude": 0.02, "phase_deg": 40.0}]}
    made_by = mechanism_from_table(table, "with both").with_values(TRUTH)
    campaign = bench(displaced(truth(), {"gear.stiffness": 1.0}), made_by, "full_46", seed=11, seconds=0.2)
    found = next(one for one in rivals_of(campaign.mechanism) if one.name == law)
    added = lay_out(substitute_law(campaign.mechanism, found), [term])
    problem = added.problem(make_problem(campaign, 1))
    start = {"anti_alias.frequency": frequency, "stepper.torque_harmonic.0.amplitude": 0.02}
    begun = problem.coordinates.point({**TRUTH, **start, "stepper.torque_harmonic.0.phase_deg": 40.0})
    solution = solve(problem, begun, problem.whole_windows())
    state = SearchState(problem, solution.q, problem.whole_windows(), outcome=FitOutcome.CONVERGED, solution=solution)
    fit = conclude(campaign, replace(state, searched=True, added=added), seed=1, seconds=1.0)
    plain, whole = initial_models(replace(fit, campaign=campaign))
    assert plain.effects == ()
    assert whole.effects == (law, term)
    assert whole.over_noise == pytest.approx(1.0, abs=0.05)
    assert whole.base.value("anti_alias.frequency") == pytest.approx(frequency, rel=0.05)
    assert plain.over_noise > 2.0
