"""Truth: the rule itself, written out: two digits of the standard error, the value to the same decimal."""

import math

import pytest

from mechid.ink.digits import digits, plain, with_sigma


@pytest.mark.parametrize(
    ("value", "sigma", "texts"),
    [
        (9.8901234, 0.00789, ("9.8901", "0.0079")),
        (0.045, 3.04e-5, ("0.045000", "0.000030")),
        (5577.8612, 0.7912, ("5577.86", "0.79")),
        (913.2, 12.6, ("913", "13")),
        (1528.0, 126.0, ("1530", "130")),
        (1.0, 0.0996, ("1.00", "0.10")),  # rounded up into the next power of ten
        (1.0, 0.00996, ("1.000", "0.010")),
        (-110.00004, 0.0096, ("-110.0000", "0.0096")),
        (-0.00001, 0.01, ("0.000", "0.010")),  # no negative zero
        (0.0, 0.5, ("0.00", "0.50")),
        (8.9123e-6, 1.23e-8, ("8.912e-06", "0.012e-06")),
        (2.5e9, 1.2e7, ("2.500e+09", "0.012e+09")),
        (0.00002, 0.3, ("0.00", "0.30")),
    ],
)
def test_value_and_sigma_end_at_the_same_decimal(value, sigma, texts):
    assert with_sigma(value, sigma) == texts


@pytest.mark.parametrize("sigma", [None, 0.0, math.nan, math.inf])
def test_without_a_usable_sigma_the_value_stands_alone(sigma):
    assert with_sigma(0.367771234, sigma) == ("0.367771", "")


@pytest.mark.parametrize("value", [None, math.nan, math.inf])
def test_what_is_no_number_is_a_dash(value):
    assert plain(value) == digits(value, 3) == "-"


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.00199876, "0.00200"), (97.8012, "97.8"), (-7.47e-5, "-0.0000747"), (1e-9, "1.00e-09"), (0.0, "0")],
)
def test_significant_digits_are_kept(value, text):
    assert digits(value, 3) == text
