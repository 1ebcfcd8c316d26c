"""What a budget makes of several steady states at a rate: the worse counts, and it is told."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.budgets.indices import Index
from mechid.budgets.line_of_sight import respond
from mechid.budgets.mode_budget import ModeBudget
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.over_rate import level_curve, rms_bands
from mechid.budgets.requirement import Requirement
from mechid.budgets.standing import nominal_level
from mechid.budgets.steadiness import steadiness, steadiness_words
from mechid.command import Command, RateProfile
from mechid.identification.result.fit_file import read_fit
from mechid.structure import Modes, Structure
from paper_estimate import write_estimate_of_paper
from states_by_hand import state_by_hand

RATES = np.array([20.0, 30.0])
MODE = OperatingMode(
    name="scan", command=Command(stepping="full", microsteps=1, rate=RateProfile.constant(20.0)), rates=RATES
)
STRUCTURE = Structure(
    name="s", line_of_sight=("x",), model=Modes(np.array([35.0]), np.array([0.01]), np.array([0.2]), np.array([[0.05]]))
)
REQUIREMENT = Requirement(
    name="r",
    index=Index("APE", 0.0),
    axis="x",
    limit_rad=1e-6,
    interpretation="temporal",
    confidence=0.95,
    evaluation_period_s=10.0,
)


def motion(rate, amplitude, *reached, periods=1, multiplier=0.5, follows=True):
    """Return a steady state of one line at the step rate."""
    return state_by_hand(
        rate,
        [2 * periods],
        [amplitude],
        periods=periods,
        gradient=np.array([[0.05 * amplitude]], dtype=complex),
        x=np.zeros(1),
        multipliers=np.array([multiplier], dtype=complex),
        follows=follows,
        size=np.ones(1),
        reached=reached,
    )


@pytest.fixture(scope="module")
def estimate(tmp_path_factory):
    """Return an estimate of one parameter, which moves each line by 5 %."""
    flying = flying_estimate(read_fit(write_estimate_of_paper(tmp_path_factory.mktemp("estimate"))), Flight())
    return replace(flying, names=("gear.damping",), covariance=np.eye(1))


def made_of(estimate, *here):
    """Return a mode whose first rate has these steady states."""
    states = tuple(tuple(respond(s, STRUCTURE) for s in each) for each in (here, [motion(30.0, 1.0, "from rest")]))
    responses = tuple(max(each, key=lambda r: r.rms()[0]) for each in states)
    return ModeBudget(MODE, responses, states, rms_band=rms_bands(responses, estimate, seed=0))


def test_the_worse_counts(estimate):
    """Truth: the level of the larger line, wherever it stands in the list."""
    small, large = motion(20.0, 1.0, "from rest"), motion(20.0, 3.0, "falling")
    made = made_of(estimate, small, large)
    curve = level_curve(REQUIREMENT, made.states, estimate, (), seed=0)
    assert curve.at == made.responses
    assert curve.level[0] == nominal_level(REQUIREMENT, [(1.0, respond(large, STRUCTURE))])
    assert curve.band[0, 0] < curve.level[0] < curve.band[0, 1]


def test_how_a_rate_was_reached_is_told_where_it_matters(estimate):
    """Truth: a third of the amplitude is outside a band of some 10 %, 0.98 of it is within."""
    apart = made_of(estimate, motion(20.0, 1.0, "from rest"), motion(20.0, 3.0, "rising", "falling"))
    (line,) = steadiness_words(apart)
    assert line == (
        'mode "scan": at 20 steps/s the disturbance depends on how the rate was reached, by a factor of up to 3; '
        "the worse counts"
    )
    (several,) = steadiness(apart)["several"]
    assert several["differs"]
    assert [(s["reached"], s["worst"]) for s in several["states"]] == [
        (["from rest"], False),
        (["rising", "falling"], True),
    ]
    near = made_of(estimate, motion(20.0, 1.0, "from rest"), motion(20.0, 0.98, "falling"))
    assert not list(steadiness_words(near))
    assert not steadiness(near)["several"][0]["differs"]


def test_odd_motions_are_told(estimate):
    """Truth: a multiplier of 0.99 over 2/20 s falls to 1/e in 9.95 s."""
    odd = made_of(estimate, motion(20.0, 1.0, "from rest", periods=2, multiplier=0.3))
    assert [
        line for line in steadiness_words(odd) if "at 20 steps/s the motion repeats only after several periods" in line
    ]
    lost = made_of(estimate, motion(20.0, 1.0, "from rest", follows=False))
    assert [line for line in steadiness_words(lost) if "at 20 steps/s the rotor does not follow" in line]
    slow = made_of(estimate, motion(20.0, 1.0, "from rest", multiplier=0.99))
    assert [line for line in steadiness_words(slow) if "at 20 steps/s transients decay in up to 9.9 s" in line]
    assert steadiness(slow)["slowest"] == {"rate": 20.0, "decay_s": pytest.approx(0.1 / -np.log(0.99))}
    assert not list(steadiness_words(made_of(estimate, motion(20.0, 1.0, "from rest"))))


def test_two_way_lines_stand_at_those_of_one_way(estimate):
    """Truth: one way two periods, joined one: the line between has no counterpart."""
    one = replace(
        motion(20.0, 1.0, "from rest", periods=2),
        orders=np.array([1, 2]),
        lines=np.array([0.1, 1.0], dtype=complex),
        gradient=np.zeros((2, 1), dtype=complex),
    )
    two = replace(motion(20.0, 0.9, "from rest"), orders=np.array([1, 2]), lines=np.array([0.9, 0.2], dtype=complex))
    made = replace(made_of(estimate, one), two_way=(respond(two, STRUCTURE),))
    torque, sight = made.two_way_lines(0)
    np.testing.assert_array_equal(torque, [np.nan, 0.9])
    assert np.isnan(sight[0]).all()
    np.testing.assert_array_equal(made.order_map.orders, [0.25, 0.5, 1.0])
