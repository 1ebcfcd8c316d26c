"""Autoregressive models against a process whose coefficients are known."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from mechid.signal.autoregression import BLOCK, _lagged_products, autocovariance, fit_autoregression

A1, A2, SIGMA = -1.5, 0.8, 0.3
"""r_k - 1.5 r_(k-1) + 0.8 r_(k-2) = e_k: poles at radius 0.894 and 33 deg, a resonance."""


def process(samples, seed):
    """Return AR(2) noise past its transient."""
    e = SIGMA * np.random.default_rng(seed).standard_normal(samples + 500)
    return lfilter([1.0], [1.0, A1, A2], e)[500:]


def true_autocovariance():
    """Closed form of lags 0 and 1 of an AR(2) process (Box and Jenkins, section 3.2.4)."""
    variance = SIGMA**2 * (1.0 + A2) / ((1.0 - A2) * ((1.0 + A2) ** 2 - A1**2))
    return variance * np.array([1.0, -A1 / (1.0 + A2)])


def spectrum(coefficients, sigma, angle):
    """Return sigma^2 / |A(e^jw)|^2."""
    powers = np.exp(-1j * np.outer(angle, np.arange(len(coefficients))))
    return sigma**2 / np.abs(powers @ np.asarray(coefficients)) ** 2


@pytest.mark.parametrize("seed", range(10))
def test_an_ar2_process_is_found(seed):
    """Truth: order 2; coefficients within 4 of their asymptotic errors sqrt(sigma^2 / N inv(Gamma))."""
    n = 20_000
    model = fit_autoregression(process(n, seed))
    errors = np.sqrt(SIGMA**2 / n * np.diag(np.linalg.inv(toeplitz(true_autocovariance()))))
    assert model.order == 2
    assert np.all(np.abs(model.coefficients - [1.0, A1, A2])[1:] < 4.0 * errors)
    assert model.sigma == pytest.approx(SIGMA, rel=4.0 / np.sqrt(2.0 * n))


@pytest.mark.parametrize("seed", range(5))
def test_its_spectrum_is_that_of_the_process(seed):
    """Truth: sigma^2/|A|^2 of the process, over a range of 300 in power; within 10 %."""
    model = fit_autoregression(process(100_000, seed))
    angle = np.linspace(0.0, np.pi, 200)
    known = spectrum([1.0, A1, A2], SIGMA, angle)
    assert known.max() / known.min() > 300.0
    np.testing.assert_allclose(spectrum(model.coefficients, model.sigma, angle), known, rtol=0.1)


@pytest.mark.parametrize("seed", range(5))
def test_a_narrow_resonance_is_found_and_whitened(seed):
    """Truth: poles of radius 0.99 at 46 Hz of 10 kHz, a range of 1e8 in power; the innovation within 4 of its errors.

    Yule-Walker of the biased autocovariance leaves three to five times too much here, and no white series.
    """
    n, a1, a2 = 10_001, -2.0 * 0.99 * np.cos(2.0 * np.pi * 46.0 / 1e4), 0.99**2
    e = np.random.default_rng(seed).standard_normal(n + 5000)
    series = lfilter([1.0], [1.0, a1, a2], e)[5000:]
    model = fit_autoregression(series)
    white = lfilter(model.coefficients, [1.0], series)[model.order :]
    assert model.order == 2
    assert model.sigma == pytest.approx(1.0, rel=4.0 / np.sqrt(2.0 * n))
    assert abs(white[1:] @ white[:-1]) / (white @ white) < 4.0 / np.sqrt(n)


@pytest.mark.parametrize("seed", range(20))
def test_the_model_is_stable(seed):
    """Truth: Burg's reflection coefficients are below 1, so all poles are inside the unit circle, also of a line."""
    t = np.arange(2000)
    rng = np.random.default_rng(seed)
    model = fit_autoregression(np.sin(0.03 * (1 + seed) * t) + 1e-6 * rng.standard_normal(t.size))
    assert model.order > 0
    assert np.max(np.abs(np.roots(model.coefficients))) < 1.0


@pytest.mark.parametrize(("samples", "most"), [(200, 7), (BLOCK + 20, 3), (50, 0)])
def test_the_lagged_products_are_the_direct_sums(samples, most):
    """Truth: sum of x_(k-i) x_(k-j) over k from `most` on."""
    x = np.random.default_rng(samples).standard_normal(samples)
    lagged = np.array([x[most - i : samples - i] for i in range(most + 1)])
    np.testing.assert_allclose(_lagged_products(x, most), lagged @ lagged.T, rtol=1e-10, atol=1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_white_noise_has_no_order(seed):
    """Truth: order 0, and sigma within 4 of its errors."""
    model = fit_autoregression(0.7 * np.random.default_rng(seed).standard_normal(20_000))
    assert model.order == 0
    assert model.sigma == pytest.approx(0.7, rel=4.0 / np.sqrt(40_000.0))


@pytest.mark.parametrize("samples", [1, 5, 1000, BLOCK, BLOCK + 7, 2 * BLOCK + 1])
def test_the_autocovariance_is_the_direct_sum(samples):
    """Truth: sum_i (x_i - m) (x_(i+k) - m) / n, over the whole series."""
    x = 3.0 + np.random.default_rng(samples).standard_normal(samples)
    away = x - 3.0
    lags = range(min(30, samples - 1) + 1)
    direct = [np.sum(away[: samples - k] * away[k:]) / samples for k in lags]
    np.testing.assert_allclose(autocovariance(x, 30, 3.0), direct, rtol=1e-10, atol=1e-13)


def test_the_autocovariance_of_the_process_is_the_closed_form():
    """Truth: Box and Jenkins; 400 000 samples, so within 2 %."""
    found = autocovariance(process(400_000, seed=1), 1)
    np.testing.assert_allclose(found, true_autocovariance(), rtol=0.02)


@pytest.mark.parametrize("series", [np.zeros(1000), np.full(1000, 3.0)])
def test_silence_is_white_and_still(series):
    model = fit_autoregression(series)
    assert (model.order, model.sigma) == (0, 0.0)


def test_few_samples_are_not_overfitted():
    """Truth: no order above a twentieth of the samples is tried."""
    assert fit_autoregression(process(60, seed=2)).order <= 3
