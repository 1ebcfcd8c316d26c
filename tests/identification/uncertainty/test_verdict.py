"""What no record knows. Truth: the range itself, in which a value scatters by its width over the root of 12."""

import math

import pytest

from mechid.campaign import catalogue_mechanism
from mechid.identification.uncertainty.verdict import describe_unknown

VISCOUS = catalogue_mechanism().parameters["friction.viscous"]
LEAST = (VISCOUS.max - VISCOUS.min) / math.sqrt(12.0)


@pytest.mark.parametrize("sigma", [math.inf, math.nan, 5e15, 1.01 * LEAST])
def test_an_error_beyond_the_allowed_range_is_none_to_print(sigma):
    assert describe_unknown(VISCOUS, 0.006, sigma).startswith("not known from these records: ")


@pytest.mark.parametrize("sigma", [0.0, 1e-4, 0.99 * LEAST])
def test_an_error_within_it_is_one(sigma):
    assert not describe_unknown(VISCOUS, 0.006, sigma)
