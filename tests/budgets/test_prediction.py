"""Verdicts on predicted torques. Truth: lines made by hand, and masks a little above or below them."""

from dataclasses import replace

import numpy as np
import pytest

from layouts import mechanism_of, paper_table
from mechid.budgets.discrepancy import Discrepancy
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.prediction import TorqueOverRate, highest_predicted_hz, predict
from mechid.command import Command, RateProfile
from mechid.specification.requirement import Mask, Requirement
from states_by_hand import state_by_hand

SIGMA = 0.02
"""Relative standard error of the lines."""
COMMAND = Command(stepping="micro", microsteps=16, rate=RateProfile.constant(1.0))


@pytest.fixture(scope="module")
def estimate():
    """Return an estimate with one parameter, of which all lines are multiples, and no residual."""
    mechanism = mechanism_of(paper_table())
    return Estimate(mechanism, ("one",), np.array([[SIGMA**2]]), Discrepancy(), {})


def torques(*amplitudes, rates=(20.0, 40.0)):
    """Return a torque over the rate: at each rate motions with a line at order 1."""

    def state(rate, size, **more):
        return state_by_hand(rate, [2], [size], gradient=np.array([[size + 0j]]), **more)

    states = [tuple(state(rate, size) for size in sizes) for rate, sizes in zip(rates, amplitudes, strict=True)]
    mode = OperatingMode(name="scan", command=COMMAND, rates=np.array(rates), highest_hz=200.0)
    return [TorqueOverRate(mode=mode, states=tuple(states))]


def requirement(limit=0.1, direction="torque", **more):
    mask = Mask(np.array([5.0, 100.0]), np.array([limit, limit]))
    return Requirement(name="r", direction=direction, kind="amplitude", mask=mask, **more)


def judged(estimate, wanted, *amplitudes):
    return predict([wanted], ("torque", "mz"), torques(*amplitudes), estimate)[0]


@pytest.mark.parametrize(
    ("line", "verdict"), [(0.09, "pass"), (0.0985, "not_shown"), (0.102, "not_shown"), (0.12, "fail")]
)
def test_a_line_against_its_mask(estimate, line, verdict):
    """Truth: a bound of 97.5 % lies 3.9 % above a line of 2 % error, one that holds at both rates 6 % below."""
    found = judged(estimate, requirement(), (0.01,), (line,))
    assert found.verdict == verdict
    assert found.judged.worst.rate == 40.0
    assert found.judged.worst.frequency_hz == 40.0
    assert found.at_rates[0].judged.verdict == "pass"


def test_the_worst_of_several_motions_counts(estimate):
    found = judged(estimate, requirement(), (0.01,), (0.01, 0.2))
    assert found.verdict == "fail"


def test_a_direction_that_is_not_predicted_is_said(estimate):
    found = judged(estimate, requirement(direction="fx"), (0.01,), (0.01,))
    assert found.verdict == "not_decidable"
    assert found.notes == (
        "r: the model predicts the torque alone, not fx; rates that were not tested are not decided.",
    )


def test_rates_that_are_not_predicted_are_said(estimate):
    found = judged(estimate, requirement(rates=((100.0, 200.0),)), (0.01,), (0.01,))
    assert found.verdict == "not_decidable"
    assert found.notes == ("r: none of its rates is predicted; it is not judged.",)


def test_the_rates_of_a_requirement_alone_are_judged(estimate):
    found = judged(estimate, requirement(rates=((10.0, 30.0),)), (0.01,), (0.9,))
    assert found.verdict == "pass"
    assert [at.rate for at in found.at_rates] == [20.0]


def test_a_part_of_the_mask_above_the_band_is_named(estimate):
    mask = Mask(np.array([5.0, 1000.0]), np.array([0.1, 0.1]))
    found = judged(estimate, replace(requirement(), mask=mask), (0.01,), (0.01,))
    assert found.judged_hz == (5.0, 200.0)
    assert "not predicted is its mask at 200 to 1000 Hz" in found.notes[0]


def test_a_rotor_that_does_not_follow_is_said(estimate):
    made = torques((0.01,), (0.01,))
    slipping = replace(made[0].states[1][0], follows=False)
    found = predict([requirement()], ("torque",), [replace(made[0], states=(made[0].states[0], (slipping,)))], estimate)
    assert "the rotor does not follow the command at 1 of the rates, 40 to 40 steps/s" in found[0].notes[0]


def test_the_prediction_reaches_to_the_end_of_the_masks(estimate):
    assert highest_predicted_hz([requirement()], estimate) == pytest.approx(100.0 * 10.0**0.05)
