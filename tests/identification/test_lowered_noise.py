"""Noise levels that stand above what a model leaves, as where impacts fill a record's spectrum, are lowered to that."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.identification.output_error.noise_level import NoiseSource
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.uncertainty.noise_levels import at_these_levels, lowered
from synthetic import COMMANDS, NOISE_NM, measured, record, truth

TWICE = 2.0
LONG, SHORT = (0, 2000), (0, 200)


def problem(**changes):
    """The mechanism that made a record, whose noise is said to be twice what was added."""
    torque = measured(truth(), COMMANDS["full_46"], np.random.default_rng(5), seconds=0.2)
    target = target_of(record("full_46", torque, COMMANDS["full_46"]))
    louder = target.each(lambda c: replace(c, sigma=TWICE * NOISE_NM, **changes))
    return Problem(SearchSpace(truth()), (louder,), substeps=4)


def level(found):
    return found.targets[0].leading.sigma


def test_a_level_above_what_is_left_falls_to_it():
    """Truth: the noise that was added; 2000 samples tell it to 2 %, three standard errors are 5 %."""
    made = problem()
    assert level(lowered(made, made.start, {"full_46": LONG})) == pytest.approx(NOISE_NM, rel=0.05)


@pytest.mark.parametrize("rests_on", [NoiseSource.DECLARED, NoiseSource.QUIET, NoiseSource.RESIDUAL])
def test_a_level_that_rests_on_more_than_high_frequencies_stays(rests_on):
    made = problem(rests_on=rests_on)
    assert lowered(made, made.start, {"full_46": LONG}) is made


def test_a_short_stretch_says_nothing():
    made = problem()
    assert lowered(made, made.start, {"full_46": SHORT}) is made


def test_a_level_that_is_right_stays():
    """Truth: the level is that of the noise added."""
    made = problem().with_sigmas({"full_46": NOISE_NM})
    assert lowered(made, made.start, {"full_46": LONG}) is made


def test_no_level_falls_below_the_resolution():
    made = problem(rounding=1.5 * NOISE_NM)
    assert level(lowered(made, made.start, {"full_46": LONG})) == 1.5 * NOISE_NM


def test_levels_go_over_to_a_problem_of_the_same_records():
    made = problem()
    quieter = lowered(made, made.start, {"full_46": LONG})
    assert level(at_these_levels(made, quieter)) == level(quieter)
