"""How records are read where they are not as declared. Truth: the declaration, changed by hand."""

import numpy as np
import pytest

from mechid.command import RateProfile
from mechid.identification.output_error.declaration import (
    DECLARED,
    Reading,
    reinterpret_campaign,
    reinterpret_command,
    reinterpret_problem,
    reinterpret_record,
    reinterpret_target,
)
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from synthetic import COMMANDS, campaign, record, truth

SAMPLES = 500
READINGS = {
    "as declared": Reading(),
    "turned": Reading(polarity=-1, direction=-1),
    "another rate": Reading(rate=RateProfile.constant(23.0), start_angle_deg=90.0),
    "a sweep": Reading(rate=RateProfile.through([[0.0, 0.0], [1.0, 46.0]])),
    "other steps": Reading(stepping="micro", microsteps=8, scale=2.0),
    "late": Reading(time_offset_s=(0.1, 0.0, 0.2)),
    "exchanged": Reading(swapped="micro_46"),
    "left out": Reading(left_out=True),
}


def made(name="full_46"):
    return record(name, np.random.default_rng(3).standard_normal(SAMPLES), COMMANDS[name])


@pytest.mark.parametrize("reading", READINGS.values(), ids=READINGS)
def test_a_reading_comes_back_from_what_is_written(reading):
    own = reading.to_dict()
    assert Reading.from_dict(own) == reading
    assert reading.changes == len(own)
    assert (own == {}) is (reading == DECLARED)


def test_a_further_reading_adds_to_the_one_before():
    """Truth: two reversals are none; what is found later goes before what was found first."""
    first = Reading(polarity=-1, scale=2.0)
    both = first.combine(Reading(polarity=-1, direction=-1, scale=3.0))
    assert (both.polarity, both.direction, both.scale) == (1, -1, 3.0)
    assert first.combine(DECLARED) == first


def test_a_command_runs_backward_at_another_rate_from_another_angle():
    reading = Reading(direction=-1, rate=RateProfile.constant(23.0), start_angle_deg=90.0)
    command = reinterpret_command(COMMANDS["full_46"], reading)
    assert command.rate.rates == (-23.0,)
    assert command.start_angle_deg == 90.0
    assert reinterpret_command(COMMANDS["full_46"], DECLARED) == COMMANDS["full_46"]


def test_samples_are_multiplied_in_target_and_record_alike():
    """Truth: the samples by hand; noise and rounding keep their share of them."""
    own, reading = made(), Reading(polarity=-1, scale=2.0)
    target = target_of(own)
    read = reinterpret_target(target, reading)
    np.testing.assert_array_equal(read.leading.measured, -2.0 * target.leading.measured)
    assert read.leading.sigma == 2.0 * target.leading.sigma
    np.testing.assert_array_equal(
        reinterpret_record(own, reading).data.channels[0].data, -2.0 * target.leading.measured
    )


def test_a_time_offset_becomes_free_within_its_bounds():
    read = reinterpret_target(target_of(made()), Reading(time_offset_s=(0.1, 0.0, 0.2)))
    offset = read.time_offset
    assert (offset.value, offset.min, offset.max, offset.is_free) == (0.1, 0.0, 0.2, True)


def test_a_record_that_is_left_out_is_kept_for_validation():
    records = [made(), made("micro_46")]
    readings = {"full_46": Reading(left_out=True)}
    read = reinterpret_campaign(campaign(truth(), *records), readings)
    assert [r.use for r in read.records] == ["validate", "estimate"]
    problem = Problem(SearchSpace(truth()), tuple(map(target_of, records)))
    assert [t.name for t in reinterpret_problem(problem, readings).targets] == ["micro_46"]


def test_what_is_taken_is_written_and_read_again():
    """Truth: the readings that were written down."""
    for taken in (
        Reading(scale=1e-3, polarity=-1),
        Reading(rate=RateProfile.constant(46.0), stepping="full", microsteps=1, swapped="a", start_angle_deg=45.0),
        Reading(rate=RateProfile.through([(0.0, 0.0), (8.0, 110.0)])),
    ):
        assert Reading.from_dict(taken.to_dict()) == taken


def test_a_further_reading_is_beside_the_first():
    """Truth: two faults of one record, found one after the other."""
    found = Reading(scale=1e-3, polarity=-1).combine(Reading(polarity=-1, start_angle_deg=45.0))
    assert found == Reading(scale=1e-3, start_angle_deg=45.0)
