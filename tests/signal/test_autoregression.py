"""Truth: the series were made from the models that are to be found, and closed forms of their moments."""

import numpy as np
import pytest
from scipy.signal import lfilter

from mechid.signal.autoregression import autocovariance, fit_autoregression

RATE_HZ = 10_000.0


def resonance(radius, frequency_hz):
    """Return 1, a_1, a_2 of a pair of poles."""
    return np.array([1.0, -2.0 * radius * np.cos(2.0 * np.pi * frequency_hz / RATE_HZ), radius**2])


def series(coefficients, sigma, samples, seed):
    """Return a stationary series: what is before it has died out."""
    e = sigma * np.random.default_rng(seed).standard_normal(samples + 2000)
    return lfilter([1.0], coefficients, e)[2000:]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("a", [np.array([1.0, -0.8]), resonance(0.9, 888.0), resonance(0.98, 46.0)])
def test_the_model_that_made_the_series_is_found(a, seed):
    """A Yule-Walker coefficient errs by about 1/sqrt(n); five times that is allowed."""
    n = 40_000
    found = fit_autoregression(series(a, 0.002, n, seed))
    assert found.order >= a.size - 1
    expected = np.zeros(found.order + 1)
    expected[: a.size] = a
    np.testing.assert_allclose(found.coefficients, expected, atol=5.0 / np.sqrt(n) * max(1.0, found.order / 2))
    assert found.sigma == pytest.approx(0.002, rel=5.0 / np.sqrt(2 * n))


@pytest.mark.parametrize("seed", range(20))
def test_white_noise_is_of_order_zero(seed):
    """The criterion's penalty ln(n) lets a spurious order through in a few of a thousand series."""
    found = fit_autoregression(np.random.default_rng(seed).standard_normal(4000))
    assert found.order == 0
    assert found.sigma == pytest.approx(1.0, rel=5.0 / np.sqrt(2 * 4000))


def test_the_autocovariance_is_that_of_the_definition():
    x = np.random.default_rng(1).standard_normal(501)
    direct = [float(np.sum(x[lag:] * x[: x.size - lag])) / x.size for lag in range(8)]
    np.testing.assert_allclose(autocovariance(x, 7), direct, atol=1e-14)


def test_a_mean_is_no_colour():
    x = np.random.default_rng(2).standard_normal(4000)
    assert fit_autoregression(x + 10.0).order == 0


@pytest.mark.parametrize("samples", [2, 5, 30])
def test_few_samples_have_few_coefficients(samples):
    found = fit_autoregression(np.random.default_rng(3).standard_normal(samples))
    assert found.order <= samples // 20
    assert np.isfinite(found.sigma)


def test_silence_is_white_and_of_no_size():
    found = fit_autoregression(np.zeros(100))
    assert (found.order, found.sigma) == (0, 0.0)
