"""The effect that whole records ask for. Truth: the mechanism that made the records, which has no added effect."""

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism
from mechid.identification.effects.campaign_disturbances import possible_disturbances
from mechid.identification.effects.disturbance import FoundDisturbance
from mechid.identification.effects.effect import add_terms
from mechid.identification.identify import make_problem
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.solve import solve
from mechid.identification.stages.whole_records import remove_effects
from mechid.plant.superset import superset_of
from synthetic import COMMANDS, TRUTH, campaign, measured, record

HARMONIC, SUPPLY = "stepper.torque_harmonic:3", "record.voltage"


def test_an_effect_that_imitates_another_is_taken_out_over_whole_records():
    """Truth: a fit as written from the true values; the state has a harmonic and supplies that the records lack."""
    mechanism = catalogue_mechanism().with_values(TRUTH)
    records = [
        record(n, measured(mechanism, COMMANDS[n], np.random.default_rng((9, k)), seconds=0.2), COMMANDS[n])
        for k, n in enumerate(("full_46", "full_23"))
    ]
    made = campaign(mechanism, *records)
    plain = make_problem(made, 1)
    supply = next(one for one in possible_disturbances(plain, made, plain.start) if one.name == SUPPLY)
    added = add_terms(superset_of(made.mechanism, only=[HARMONIC]), [HARMONIC])
    wide = added.problem(plain, [supply])
    q = wide.coordinates.point({**TRUTH, "stepper.torque_harmonic.0.amplitude": 0.05})
    start = dict.fromkeys(wide.whole_windows(), (0, 500))
    state = SearchState(wide, q, start, added=added, found=(FoundDisturbance(supply, 9.0, 1.0),))
    bare = remove_effects(state, plain.space.mechanism)
    assert bare.added is None
    assert bare.found == ()
    assert bare.problem.coordinates.names == plain.coordinates.names
    assert bare.windows == plain.whole_windows()
    best = solve(plain, plain.coordinates.point(TRUTH), bare.windows).q
    assert bare.problem.total_norm(bare.q, bare.windows) == pytest.approx(
        plain.total_norm(best, bare.windows), rel=1e-4
    )
    assert bare.values["gear.stiffness"] == pytest.approx(TRUTH["gear.stiffness"], rel=1e-3)
