"""Growth with added terms: which disturbances it keeps. Truth: the chi-square of a hum that was added."""

import math

import numpy as np
import pytest

from mechid.identification.effects.augmented import augment
from mechid.identification.effects.disturbance import Disturbance
from mechid.identification.effects.effect import AddedTerms
from mechid.identification.effects.settings import DURING_FIT
from mechid.identification.identify import make_problem
from mechid.identification.output_error.problem import transfer_values
from mechid.identification.search.gates import Growth
from mechid.identification.stages.term_growth import Reached, needed_disturbances
from synthetic import COMMANDS, NOISE_NM, RATE_HZ, TRUTH, campaign, displaced, measured, record, truth

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
    return plain, Reached(model, growth)


@pytest.mark.parametrize("chi_square", [0.0, 6.0, 14.0])
def test_a_hum_that_may_be_chance_is_not_named(chi_square):
    plain, reached = with_hum(chi_square)
    found, problem, q = needed_disturbances(reached)
    assert found == ()
    assert [t.leading.turns for t in problem.targets] == [t.leading.turns for t in plain.targets]
    assert problem.coordinates.names == plain.coordinates.names
    assert q.size == plain.size


def test_a_clear_hum_is_kept_with_what_it_explains():
    plain, reached = with_hum(200.0)
    (found,), problem, _ = needed_disturbances(reached)
    assert found.disturbance is HUM
    assert found.share == 1.0
    assert found.chi_square > DURING_FIT.least_chi_square
    assert found.chi_square == pytest.approx(200.0, abs=4.0 * 2.0 * math.sqrt(200.0)), "its scatter is 2 sqrt(chi2)"
    assert len(problem.targets[0].leading.turns) == len(plain.targets[0].leading.turns) + 1
