"""Alternative readings of one record, under a model that the others have determined."""

import numpy as np
import pytest

from mechid.command import Command, RateProfile
from mechid.command.stepping import MOST_MICROSTEPS
from mechid.identification.identify import make_problem
from mechid.identification.output_error.declaration import Reading, reinterpret_command
from mechid.identification.readings.alternatives import describe_saturation, distinct_turns_deg, judge, other_steppings
from odd_records import SECONDS, bending, made
from synthetic import (
    COMMANDS,
    RATE_HZ,
    campaign,
    measured,
    measuring,
    record,
    torque_of,
    truth,
)


@pytest.mark.parametrize(
    ("stepping", "microsteps", "tried"),
    [
        ("full", 1, [("half", 2, 46.0), ("half", 2, 23.0)]),
        ("half", 2, [("micro", 4, 46.0), ("micro", 4, 23.0), ("full", 1, 46.0), ("full", 1, 92.0)]),
        ("micro", 5, [("micro", 10, 46.0), ("micro", 10, 23.0)]),
        ("micro", MOST_MICROSTEPS, [("micro", 32768, 46.0), ("micro", 32768, 92.0)]),
    ],
)
def test_steps_may_be_twice_or_half_as_many(stepping, microsteps, tried):
    """Truth: by hand, at the declared rate and with the declared pulses; each is a command that can be."""
    command = Command(stepping=stepping, microsteps=microsteps, rate=RateProfile.constant(46.0))
    read = [reinterpret_command(command, taken) for taken in other_steppings(command)]
    assert [(c.stepping, c.microsteps, c.rate.rates[0]) for c in read] == tried


def test_a_record_of_another_mechanism_does_not_bend():
    """Truth: another load made it, no transducer; the words of a sensor that saturates are not used."""
    other = torque_of(truth({"load.inertia": 0.03}), COMMANDS["full_46"], round(SECONDS * RATE_HZ) + 1)
    problem = make_problem(made(start=truth()), 1)
    target = measuring(problem.targets[0], other)
    assert describe_saturation(problem, problem.start, target) == ""
    bent = measuring(problem.targets[0], bending(problem.targets[0].leading.measured[:]))
    assert "saturates" in describe_saturation(problem, problem.start, bent)


SWEEP = Command(stepping="micro", microsteps=16, rate=RateProfile.through([(0.0, 0.0), (1.5, 90.0)]))


def test_a_gain_is_looked_for_beyond_the_first_moments():
    """Truth: a sweep times 0.9, of which the first moments are small; the gain is found over all of it."""
    rng = np.random.default_rng(7)
    y = measured(truth(), SWEEP, rng, seconds=1.5)
    problem = make_problem(campaign(truth(), record("sweep", 0.9 * y, SWEEP)), 1)
    target = problem.targets[0]
    declared, found, *_ = judge(problem, problem.start, target, target.samples)
    assert not declared.follows
    assert found.follows
    assert found.reading.scale == pytest.approx(1.0 / 0.9, rel=1e-3)
    assert found.samples == target.samples


def test_turns_that_no_torque_shows_are_not_tried():
    """Truth: orders 4 and 2 come again after half an electrical turn, 4 alone after a quarter, 1 after a whole one."""
    full, micro = COMMANDS["full_46"], COMMANDS["micro_46"]
    assert distinct_turns_deg(full, (4.0, 2.0)) == (0.0, 45.0, -45.0, 90.0)
    assert distinct_turns_deg(full, (4.0,)) == (0.0, 45.0)
    assert distinct_turns_deg(full, (4.0, 1.0)) == (0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0)
    assert len(distinct_turns_deg(micro, (4.0, 2.0))) == 32
    assert distinct_turns_deg(micro, ()) == (0.0,)


def test_a_command_taken_backward_runs_backward():
    """Truth: the command's own edges, of which the other direction has the mirror image."""
    command = COMMANDS["full_46"]
    there, back = command.excitation(0.1), reinterpret_command(command, Reading(direction=-1)).excitation(0.1)
    np.testing.assert_array_equal(there.times, back.times)
    np.testing.assert_allclose(there.values[0], [1, 1] * np.sqrt(np.array([0.5, 0.5])), atol=1e-12)
    np.testing.assert_allclose(back.values[0], [-1, -1] * np.sqrt(np.array([0.5, 0.5])), atol=1e-12)
