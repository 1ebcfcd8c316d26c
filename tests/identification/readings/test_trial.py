"""The short search over first steps: records as declared, read otherwise, and with terms of the mechanism free."""

from dataclasses import replace

import numpy as np
import pytest

from layouts import changed
from mechid.campaign import catalogue_mechanism, mechanism_from_table
from mechid.command import RateProfile
from mechid.identification.identify import make_problem
from mechid.identification.output_error.declaration import Reading
from mechid.identification.readings.trial import compare_readings, declared_readings, first_moments, samples_until
from mechid.identification.search.settings import SEARCH
from recovery.mechanisms import paper_table
from synthetic import COMMANDS, RATE_HZ, campaign, measured, record, truth

HALF = {"full_46": Reading(rate=RateProfile.constant(23.0))}


def problem(y):
    """Return the problem of one record, as it is declared."""
    return make_problem(campaign(catalogue_mechanism(), record("full_46", y, COMMANDS["full_46"])), 1)


@pytest.fixture(scope="module")
def right():
    return problem(measured(truth(), COMMANDS["full_46"], np.random.default_rng(7), seconds=0.5))


def test_samples_are_counted_by_the_travel_of_the_command(right):
    """Truth: by hand, the k-th of 46 steps a second at k/46 s; 60 ms are left after two of them."""
    (target,) = right.targets
    assert samples_until(target, 1.0) == pytest.approx(RATE_HZ / 46.0, abs=1.0)
    assert first_moments(target) == pytest.approx(RATE_HZ * (2.0 / 46.0 + 0.06), abs=1.0)
    resting = replace(target, command=replace(target.command, rate=RateProfile.constant(0.0)))
    assert samples_until(resting, 1.0) == resting.samples


def test_a_right_declaration_explains_and_a_wrong_rate_does_not(right):
    """Truth: the record as it was made."""
    declared, half = compare_readings(right, [declared_readings(["full_46"]), HALF])
    assert declared.explains
    assert half.cost > 100.0
    assert declared.is_better_than(half)
    assert not half.is_better_than(declared)


@pytest.mark.slow
def test_a_term_that_the_file_lacks_explains_a_record_once_it_is_free():
    """Truth: phase offsets of 0.25 and -0.25 V, which the catalogue lacks and which are one of its terms."""
    table = changed(paper_table(), {"stepper": {"imbalance": {"offset_a": 0.25, "offset_b": -0.25}}})
    offset = mechanism_from_table(table, "with offsets").with_values(
        {name: truth().value(name) for name in truth().parameters}
    )
    own = problem(measured(offset, COMMANDS["full_46"], np.random.default_rng(7), seconds=0.5))
    names = declared_readings(["full_46"])
    ((plain,), (wide,)) = (compare_readings(own, [names], with_terms=free) for free in (False, True))
    assert plain.cost > 2.0 * SEARCH.good_cost
    assert wide.explains
