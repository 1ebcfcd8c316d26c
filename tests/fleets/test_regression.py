"""Mean and spread of a fleet. Truth: closed forms, a published data set, and coverage over seeded draws."""

import numpy as np
import pytest
from scipy.stats import linregress, t

from mechid.fleets.regression import prediction_interval95, random_effects_mean, regression

BCG = np.array(
    [
        (-0.8893, 0.3256),
        (-1.5854, 0.1946),
        (-1.3481, 0.4154),
        (-1.4416, 0.0200),
        (-0.2175, 0.0512),
        (-0.7861, 0.0069),
        (-1.6209, 0.2230),
        (0.0120, 0.0040),
        (-0.4694, 0.0564),
        (-1.3713, 0.0730),
        (-0.3394, 0.0124),
        (0.4459, 0.5325),
        (-0.0173, 0.0714),
    ]
)
"""Log relative risks of 13 trials of the BCG vaccine with their variances (Colditz et al. 1994), to four decimals."""


def drawn(rng, n, spread):
    """Return values about 3 and their errors, which differ by up to a factor of 4."""
    errors = 2.0 ** rng.uniform(-1.0, 1.0, n)
    return 3.0 + spread * rng.standard_normal(n) + errors * rng.standard_normal(n), errors


def test_with_equal_errors_it_is_the_classical_mean_and_the_variance_less_that_of_the_errors():
    values = np.array([1.0, 4.0, 2.0, 9.0, 5.0])
    made = random_effects_mean(values, np.full(5, 0.5))
    assert made.coefficients[0] == pytest.approx(values.mean(), rel=1e-12)
    assert made.scatter**2 == pytest.approx(values.var(ddof=1) - 0.25, rel=1e-9)
    reach = t.ppf(0.975, 4) * values.std(ddof=1) / np.sqrt(5.0)
    assert made.interval() == pytest.approx((values.mean() - reach, values.mean() + reach), rel=1e-9)


def test_units_alike_have_no_spread_and_the_weighted_mean():
    values, errors = np.array([1.0, 1.1, 0.9]), np.array([0.5, 1.0, 2.0])
    made = random_effects_mean(values, errors)
    assert made.scatter == 0.0
    assert made.coefficients[0] == pytest.approx(np.average(values, weights=errors**-2.0))
    assert made.error() == pytest.approx(np.sum(errors**-2.0) ** -0.5)


def test_a_published_data_set():
    """Paule and Mandel's tau^2 0.318 and mean -0.715, Q-profile 0.120 to 1.112 and Q 152.23: R's metafor."""
    values, errors = BCG[:, 0], np.sqrt(BCG[:, 1])
    made = random_effects_mean(values, errors)
    assert made.scatter**2 == pytest.approx(0.3181, abs=2e-4)
    assert made.coefficients[0] == pytest.approx(-0.7150, abs=2e-4)
    assert np.square(made.scatter95) == pytest.approx((0.1197, 1.1115), abs=5e-4)
    assert made.equal_p < 1e-20


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_a_line_without_errors_is_that_of_least_squares_in_any_unit(unit):
    x, y = np.arange(6.0), np.array([0.1, 1.3, 1.9, 3.2, 3.8, 5.3]) * unit
    made = regression(y, np.full(6, 1e-6 * unit), np.column_stack([x, np.ones(6)]))
    truth = linregress(x, y)
    assert made.coefficients == pytest.approx([truth.slope, truth.intercept])
    assert made.error() == pytest.approx(truth.stderr)
    assert made.p_value() == pytest.approx(truth.pvalue, rel=1e-6)


@pytest.mark.parametrize("spread", [0.5, 1.0, 4.0])
def test_intervals_hold_what_they_promise(spread):
    """Over 300 draws 95 % are met with a standard error of 1.3 %; three of them are allowed."""
    rng, hits = np.random.default_rng(5), np.zeros((300, 3))
    for k in range(300):
        values, errors = drawn(rng, 8, spread)
        made, further = random_effects_mean(values, errors), 3.0 + spread * rng.standard_normal()
        intervals = (made.interval(), made.scatter95, prediction_interval95(values, errors))
        hits[k] = [low <= truth <= high for (low, high), truth in zip(intervals, (3.0, spread, further), strict=True)]
    mean, scatter, another = hits.mean(axis=0)
    assert 0.91 < mean < 0.99
    assert 0.91 < scatter < 0.99
    assert 0.91 < another <= 1.0


def test_units_alike_are_said_to_differ_as_often_as_the_level_says():
    rng = np.random.default_rng(6)
    p = [random_effects_mean(*drawn(rng, 8, 0.0)).equal_p for _ in range(300)]
    assert 0.01 < np.mean(np.array(p) < 0.05) < 0.09
