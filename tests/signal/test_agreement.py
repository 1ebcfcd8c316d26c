"""Truth: Theil's definition on numbers worked by hand, and errors of one kind alone."""

import math

import numpy as np
import pytest

from mechid.signal import fit_percent, theil_inequality

SINE = np.sin(2.0 * np.pi * np.arange(200) / 50.0)


def test_by_hand():
    """Mean 2.5 of both; squared error 1/2; variances 5/4 and 3/4; squares 7.5 and 7."""
    found = theil_inequality(np.array([1.0, 2.0, 3.0, 4.0]), np.array([2.0, 2.0, 2.0, 4.0]))
    variance = (math.sqrt(1.25) - math.sqrt(0.75)) ** 2 / 0.5
    assert found.coefficient == pytest.approx(math.sqrt(0.5) / (math.sqrt(7.5) + math.sqrt(7.0)))
    assert found.bias == pytest.approx(0.0)
    assert found.variance == pytest.approx(variance)
    assert found.covariance == pytest.approx(1.0 - variance)


@pytest.mark.parametrize(
    ("predicted", "part"),
    [(SINE + 0.3, "bias"), (0.8 * SINE, "variance"), (np.roll(SINE, 5), "covariance")],
)
def test_an_error_of_one_kind_is_all_of_its_part(predicted, part):
    """A shifted mean, a wrong amplitude, a wrong phase over whole periods."""
    found = theil_inequality(SINE, predicted)
    assert getattr(found, part) == pytest.approx(1.0)
    assert found.bias + found.variance + found.covariance == pytest.approx(1.0)


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.0, 3.0])
def test_a_wrong_amplitude_has_its_coefficient_in_closed_form(factor):
    """U = |1 - a| / (1 + a) for a prediction a times the measured."""
    assert theil_inequality(SINE, factor * SINE).coefficient == pytest.approx(abs(1.0 - factor) / (1.0 + factor))


def test_a_failed_prediction_has_no_numbers():
    found = theil_inequality(SINE, np.full(SINE.size, math.nan))
    assert all(math.isnan(v) for v in (found.coefficient, found.bias, found.variance, found.covariance))


def test_fit_percent_by_hand():
    """||r|| = 1 beside ||y - mean|| = sqrt(5), the mean taken off the measured alone."""
    measured = np.array([11.0, 12.0, 13.0, 14.0])
    assert fit_percent(measured, np.array([1.0, 0.0, 0.0, 0.0])) == pytest.approx(100.0 * (1.0 - 1.0 / math.sqrt(5.0)))
    assert math.isnan(fit_percent(np.ones(4), np.zeros(4)))


def test_samples_that_do_not_count_are_as_if_they_were_not_there():
    """Truth: the same of the arrays without them, over more than one block."""
    rng = np.random.default_rng(5)
    measured, predicted = rng.standard_normal(150_000) + 1.0, rng.standard_normal(150_000)
    rejected = np.array([0, 17, 65_535, 65_536, 149_999])
    y, p = np.delete(measured, rejected), np.delete(predicted, rejected)
    assert theil_inequality(measured, predicted, rejected).bias == pytest.approx(theil_inequality(y, p).bias)
    assert theil_inequality(y, p).bias == pytest.approx((y.mean() - p.mean()) ** 2 / np.mean((y - p) ** 2))
    share = np.linalg.norm(p) / np.linalg.norm(y - y.mean())
    assert fit_percent(measured, predicted, rejected) == pytest.approx(100.0 * (1.0 - share))
