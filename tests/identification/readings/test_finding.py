"""Findings in words: where, what is wrong, what to write."""

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism
from mechid.command import RateProfile
from mechid.identification.identify import make_problem
from mechid.identification.output_error.declaration import Reading
from mechid.identification.readings.finding import (
    UNEXPLAINED,
    Confidence,
    DeclaredRecords,
    Finding,
    misread_names,
    reading_words,
    unit_remedy,
)
from synthetic import COMMANDS, campaign, record

BENCH = campaign(catalogue_mechanism(), record("full_46", np.zeros(2001), COMMANDS["full_46"]))


@pytest.mark.parametrize(
    ("records", "where"),
    [
        ((), "all records: "),
        (("a",), "record a: "),
        (("a", "b"), "records a and b: "),
        (("a", "b", "c"), "records a, b, c: "),
    ],
)
def test_a_line_says_where_what_and_what_to_do(records, where):
    finding = Finding(records, "unit", "it is too large", "write another unit")
    assert finding.line() == f"{where}it is too large; write another unit"
    assert finding.line(used=True) == f"{where}it is too large (read so in this fit); write another unit"
    assert Finding(records, "unit", "it is too large").line() == f"{where}it is too large"


def test_only_what_a_fit_supports_alone_is_confirmed():
    confirmed = {one for one in Confidence if Finding((), "unit", "", confidence=one).is_confirmed}
    assert confirmed == {Confidence.CONFIRMED}
    assert not Finding((), "unit", "").is_confirmed


def test_records_that_are_read_otherwise_or_unexplained_are_misread():
    findings = (
        Finding(("a", "b"), "swapped", "", reading={"a": Reading(), "b": Reading()}),
        Finding(("c",), UNEXPLAINED, ""),
        Finding(("d",), "clock", ""),
    )
    assert misread_names(findings) == {"a", "b", "c"}


@pytest.mark.parametrize(
    ("reading", "words", "remedy"),
    [
        (Reading(polarity=-1), "of the other sign", "the other sign of its torque channel's gain"),
        (Reading(direction=-1), "its commanded rate of the other sign", "the other sign of its rate"),
        (Reading(scale=1e-3), "torque times 0.001", 'unit = "mN*m" in its torque channel'),
        (Reading(scale=1.1), "torque times 1.1", "1.1 times the gain of its torque channel"),
        (Reading(stepping="micro", microsteps=16), '(declared stepping = "full")', "microsteps = 16"),
        (Reading(rate=RateProfile.constant(23.0)), "rate = 23 full steps/s (declared 46.0)", "rate = 23"),
        (Reading(start_angle_deg=90.0), "a start angle of 90 deg (declared 45)", "start_angle_deg = 90"),
        (Reading(time_offset_s=(3e-3, 0.0, 6e-3)), "a time offset of about 0.003 s", "min = 0, max = 0.006"),
    ],
)
def test_a_reading_says_what_was_declared_and_what_to_write(reading, words, remedy):
    """Truth: the entries of a campaign file."""
    said, written = reading_words(BENCH.records[0], reading)
    assert words in said
    assert remedy in written


def test_a_remedy_counts_on_from_the_unit_that_is_declared():
    """Truth: ounce inches are 7.0616 mN m."""
    assert unit_remedy(BENCH.records[0], 7.061551833333333e-3) == 'unit = "ozf*in" in its torque channel'


def test_only_records_that_step_have_spectra_to_read():
    """Truth: a command that never steps draws no line."""
    still = campaign(catalogue_mechanism(), record("full_46", np.zeros(20), COMMANDS["full_46"]))
    for bench, names in ((BENCH, ["full_46"]), (still, [])):
        records = DeclaredRecords(bench, make_problem(bench, 1))
        assert [t.name for t in records.readable] == names
    assert records.unit_factor("full_46") == 1.0
