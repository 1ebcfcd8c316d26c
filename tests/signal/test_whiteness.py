"""Truth: the test worked by hand and by statsmodels; autoregressions whose autocorrelation is known."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from mechid.signal import effective_samples, ljung_box
from mechid.signal.autoregression import autocovariance_of_accepted

CHIRP = np.cos(np.arange(40.0) ** 2)
COEFFICIENTS = {
    "white": [1.0],
    "red": [1.0, -0.8],
    "blue": [1.0, 0.8],
    "housing": [1.0, -2.0 * 0.9 * math.cos(2.0 * math.pi * 888.0 / 1e4), 0.81],
    "resonance": [1.0, -2.0 * 0.99 * math.cos(2.0 * math.pi * 46.0 / 1e4), 0.9801],
}
"""Autoregressions: of first order, and of second order with poles at 888 Hz and 46 Hz of 10 kHz."""


def sum_of_squares(coefficients):
    """Return the sum over all lags of rho^2, from the autocovariance of the impulse response."""
    impulse = lfilter([1.0], coefficients, np.eye(1, 20_000)[0])
    covariance = np.correlate(impulse, impulse, mode="full")
    return float(np.sum((covariance / covariance.max()) ** 2))


def test_by_hand():
    """rho_1 = -3/4 of +1 -1 +1 -1, Q = 4 x 6 x (9/16) / 3 = 4.5; p is erfc(sqrt(Q / 2))."""
    found = ljung_box(np.array([1.0, -1.0, 1.0, -1.0]), lags=1)
    assert found.statistic == pytest.approx(4.5)
    assert found.p_value == pytest.approx(math.erfc(1.5))
    assert found.largest == pytest.approx(-0.75)


@pytest.mark.parametrize(
    ("lags", "statistic", "p_value"),
    [(5, 4.359880016164695, 0.49884693833816485), (25, 32.66515103078751, 0.13965381798452237)],
)
def test_as_statsmodels(lags, statistic, p_value):
    """Truth: statsmodels 0.15.0, acorr_ljungbox of the same series."""
    found = ljung_box(CHIRP, lags)
    assert found.statistic == pytest.approx(statistic, rel=1e-12)
    assert found.p_value == pytest.approx(p_value, rel=1e-10)


def test_white_noise_fails_at_the_level_of_the_test():
    """Of 1000 white series 5 % have p below 0.05; within four of its binomial standard deviations."""
    rng = np.random.default_rng(11)
    rejected = sum(ljung_box(rng.standard_normal(2000)).p_value < 0.05 for _ in range(1000))
    assert abs(rejected - 50) < 4.0 * math.sqrt(1000 * 0.05 * 0.95)


def test_a_line_far_below_the_noise_is_seen():
    rng = np.random.default_rng(12)
    line = 0.3 * np.sin(2.0 * np.pi * 46.0 / 1e4 * np.arange(20_000))
    assert ljung_box(rng.standard_normal(20_000) + line).p_value < 1e-6


@pytest.mark.parametrize("series", [np.zeros(50), np.full(50, math.nan)])
def test_a_constant_or_lost_series_has_no_test(series):
    assert math.isnan(ljung_box(series).p_value)
    assert math.isnan(effective_samples(series))


@pytest.mark.parametrize("colour", COEFFICIENTS)
def test_effective_samples_are_those_of_the_autocorrelation(colour):
    """Truth: n over the sum of the squared autocorrelation, known from the coefficients."""
    n = 400_000
    noise = np.random.default_rng(13).standard_normal(n)
    expected = n / sum_of_squares(COEFFICIENTS[colour])
    assert effective_samples(lfilter([1.0], COEFFICIENTS[colour], noise)) == pytest.approx(expected, rel=0.05)


def test_first_order_in_closed_form():
    assert sum_of_squares(COEFFICIENTS["red"]) == pytest.approx((1.0 + 0.64) / (1.0 - 0.64))


def test_they_are_what_the_scatter_of_the_sum_of_squares_says():
    """Truth: the variance of the mean square, 2 sigma^4 / n_eff, over 1000 draws; its own error is 4.5 %."""
    rng = np.random.default_rng(14)
    draws = [lfilter([1.0], COEFFICIENTS["red"], rng.standard_normal(4100))[100:] for _ in range(1000)]
    power = [float(np.mean(draw**2)) for draw in draws]
    scatter = 2.0 * np.mean(power) ** 2 / np.var(power)
    assert np.mean([effective_samples(draw) for draw in draws]) == pytest.approx(scatter, rel=0.15)


def test_the_autocovariance_among_those_that_count_is_the_direct_sum():
    """Truth: the sum over pairs both of which count, by a mask."""
    rng = np.random.default_rng(19)
    x, counted = rng.standard_normal(70_000) + 4.0, np.ones(70_000)
    rejected = np.array([0, 1, 5, 9, 65_535, 65_536, 69_998])
    counted[rejected] = 0.0
    n, found = autocovariance_of_accepted(x, 6, rejected)
    centred = (x - x[counted > 0.0].mean()) * counted
    assert n == 70_000 - rejected.size
    for lag in range(7):
        one, other = slice(0, 70_000 - lag), slice(lag, None)
        pairs = counted[one] @ counted[other]
        expected = centred[one] @ centred[other] / pairs * (70_000 - lag) / 70_000
        assert found[lag] == pytest.approx(expected, rel=1e-9, abs=1e-12)
