"""Levels at a confidence against closed forms and brute-force sampling; ECSS's sums beside them."""

import numpy as np
import pytest
from scipy import stats

from mechid.budgets.indices import Index
from mechid.budgets.levels import constant_member, level, mixed_level
from mechid.budgets.pointing_error import PointingError, Random, Source
from mechid.budgets.shares import band_from_draws
from mechid.budgets.summation import Contribution, coverage_factor, total

APE = Index("APE")


def line(*phasor, f=10.0, order=1, name="a"):
    return Source(name, f, np.array([order]), np.array([phasor], dtype=complex))


def white(*sigmas):
    """Return white noise to 100 Hz."""
    f = np.linspace(0.0, 100.0, 1001)
    return (Random(f, np.tile(np.array(sigmas) ** 2 / (1001 * 0.1), (1001, 1))),)


@pytest.mark.parametrize("confidence", [0.5, 0.95, 0.9973])
def test_a_line_is_arcsine_distributed(confidence):
    """Truth: P(|A cos| < x) = 2/pi asin(x/A)."""
    error = PointingError(np.zeros(1), (line(2.0j),))
    assert level(error, APE, confidence, 0) == pytest.approx(2.0 * np.sin(0.5 * np.pi * confidence), rel=1e-5)


@pytest.mark.parametrize("confidence", [0.68, 0.9973])
def test_noise_is_gaussian_and_its_cone_rayleigh(confidence):
    """Truth: the Gaussian and the Rayleigh quantile; the cone is sampled, hence 1 %."""
    error = PointingError(np.zeros(2), (), white(3.0, 3.0))
    assert level(error, APE, confidence, 0) == pytest.approx(3.0 * coverage_factor(confidence), rel=1e-6)
    assert level(error, APE, confidence, None) == pytest.approx(3.0 * coverage_factor(confidence, cone=True), rel=1e-2)


def test_bias_and_noise():
    """Truth: the folded normal distribution."""
    error = PointingError(np.array([1.5]), (), white(1.0))
    assert level(error, APE, 0.9, 0) == pytest.approx(stats.foldnorm(1.5).ppf(0.9), rel=1e-6)


def test_line_noise_and_bias_together():
    """Truth: a million draws of the sum, whose quantile has a standard error of some 0.1 %."""
    rng = np.random.default_rng(4)
    draws = 0.4 + 2.0 * np.cos(rng.uniform(0.0, 2.0 * np.pi, 1_000_000)) + rng.normal(0.0, 0.5, 1_000_000)
    error = PointingError(np.array([0.4]), (line(2.0),), white(0.5))
    for confidence in (0.5, 0.95, 0.9973):
        expected = np.quantile(np.abs(draws), confidence)
        assert level(error, APE, confidence, 0) == pytest.approx(expected, rel=5e-3)


def test_lines_of_one_source_add_coherently_and_of_two_do_not():
    """Truth: cos + cos 2x peaks at 2; the same of two sources is the sum of independent arcsines, by draws."""
    together = Source("a", 10.0, np.array([1, 2]), np.ones((2, 1), dtype=complex))
    theta = 2.0 * np.pi * (np.arange(100_000) + 0.5) / 100_000
    one = np.abs(np.cos(theta) + np.cos(2.0 * theta))
    coherent = PointingError(np.zeros(1), (together,))
    assert level(coherent, APE, 0.95, 0) == pytest.approx(np.quantile(one, 0.95), rel=2e-3)
    rng = np.random.default_rng(5)
    two = np.abs(np.cos(rng.uniform(0, 2 * np.pi, (2, 1_000_000))).sum(axis=0))
    apart = PointingError(np.zeros(1), (line(1.0), line(1.0, f=13.7, name="b")))
    assert level(apart, APE, 0.95, 0) == pytest.approx(np.quantile(two, 0.95), rel=5e-3)


def test_the_cone_of_a_line_that_circles():
    """Truth: two axes a quarter turn apart stay at one angle, its amplitude."""
    error = PointingError(np.zeros(2), (line(2.0, 2.0j),))
    for confidence in (0.1, 0.99):
        assert level(error, APE, confidence, None) == pytest.approx(2.0, rel=1e-9)


@pytest.mark.parametrize("periods", [0.1, 0.7, 3.3])
def test_relative_error_of_a_line_over_a_window(periods):
    """Truth: the definition on draws of the window's place and of the instant in it."""
    rng = np.random.default_rng(6)
    start, tau = rng.uniform(0.0, 1.0, 1_000_000), rng.uniform(0.0, periods, 1_000_000)
    turn = 2.0 * np.pi
    mean = (np.sin(turn * (start + periods)) - np.sin(turn * start)) / (turn * periods)
    draws = np.abs(np.cos(turn * (start + tau)) - mean)
    error = PointingError(np.array([7.0]), (line(1.0),))  # the bias does not count
    for confidence in (0.5, 0.95):
        got = level(error, Index("RPE", periods / 10.0), confidence, 0)
        assert got == pytest.approx(np.quantile(draws, confidence), rel=5e-3)
    np.testing.assert_allclose(error.rms(Index("RPE", periods / 10.0))[0], np.sqrt(np.mean(draws**2)), rtol=3e-3)


def test_summation_of_a_worked_case():
    """Truth: worked by hand from the standard's rules, n_p = 2."""
    confidence = float(stats.chi2(1).cdf(4.0))
    errors = [
        Contribution(name="alignment", kind="bias", size=3.0, spread=1.0),
        Contribution(name="noise", kind="random", size=2.0, spread=0.5),
        Contribution(name="line", kind="periodic", size=4.0, spread=1.0),
    ]
    temporal = 5.0 + 2.0 * np.sqrt(3.0**2 + 6.0**2 / 2.0)
    ensemble = (3.0 + 4.0 + 4.0) + 2.0 * np.sqrt(1.0 + 1.0 + 1.0)
    mixed = 3.0 + 2.0 * np.sqrt(1.0 + 4.25 + 17.0 / 2.0)
    for interpretation, expected in (("temporal", temporal), ("ensemble", ensemble), ("mixed", mixed)):
        assert total(errors, interpretation, confidence) == pytest.approx(expected, rel=1e-9)


def test_correlated_errors_add_linearly():
    """Truth: n_p (s + s) within a group, n_p sqrt(2) s without."""
    pair = [Contribution(name=n, kind="random", size=1.0, group="g") for n in "ab"]
    apart = [Contribution(name=n, kind="random", size=1.0) for n in "ab"]
    n_p = coverage_factor(0.95)
    assert total(pair, "mixed", 0.95) == pytest.approx(2.0 * n_p)
    assert total(apart, "mixed", 0.95) == pytest.approx(np.sqrt(2.0) * n_p)


def test_a_line_alone_shows_why_the_central_limit_is_not_enough():
    """Truth: a line never exceeds its amplitude; the standard's sum at 99.73 % is 3/sqrt(2) of it."""
    (c,) = [Contribution(name="line", kind="periodic", size=1.0)]
    assert total([c], "temporal", 0.9973) == pytest.approx(3.0 / np.sqrt(2.0), rel=1e-4)
    assert level(PointingError(np.zeros(1), (line(1.0),)), APE, 0.9973, 0) <= 1.0


def test_a_drawn_band():
    """Truth: the variance of 2 a - b, written out, and 200 000 draws; of x^2 2, none of it a straight line's."""
    covariance = np.array([[1.0, 0.6], [0.6, 4.0]])
    band = band_from_draws(5.0, lambda by: 5.0 + 2.0 * by[0] - by[1], covariance, ("a", "b"))
    variance = 4.0 * 1.0 - 2.0 * 2.0 * 0.6 + 4.0
    assert band.sigma == pytest.approx(np.sqrt(variance), rel=0.01)
    assert band.shares["a"] == pytest.approx((4.0 - 1.2) / variance, abs=0.01)
    assert band.shares["curvature"] == pytest.approx(0.0, abs=0.01)
    assert sum(band.shares.values()) == pytest.approx(1.0)
    draws = 5.0 + np.random.default_rng(7).multivariate_normal([0, 0], covariance, 200_000) @ [2.0, -1.0]
    np.testing.assert_allclose(band.ci95, np.quantile(draws, [0.025, 0.975]), atol=0.05)
    curved = band_from_draws(0.0, lambda by: by[0] ** 2, np.eye(1), ("a",))
    assert curved.sigma == pytest.approx(np.sqrt(2.0), rel=0.05)
    assert curved.shares["curvature"] == pytest.approx(1.0, abs=0.05)
    assert band_from_draws(1.0, lambda by: 1.0, np.zeros((1, 1)), ("a",)).sigma == 0.0


def test_mixed_of_a_member_is_its_level():
    error = PointingError(np.zeros(1), (line(1.0),), white(0.2))
    assert mixed_level([constant_member(error)] * 2, APE, 0.9, 0) == pytest.approx(level(error, APE, 0.9, 0), rel=1e-9)
