"""Readings of a record, as estimate.json keeps them."""

from mechid.command import RateProfile
from mechid.identification.output_error.declaration import Reading


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
    found = Reading(scale=1e-3, polarity=-1).beside(Reading(polarity=-1, start_angle_deg=45.0))
    assert found == Reading(scale=1e-3, start_angle_deg=45.0)
