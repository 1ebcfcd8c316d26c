"""Bounds. Truth: simulated noise, and tables of the chi-square distribution."""

import numpy as np
import pytest
from scipy.stats import ncx2

from mechid.emissions.bounds import difference_bounds, line_bounds, power_bounds


@pytest.mark.parametrize("amplitude", [0.0, 0.5, 2.0, 10.0])
@pytest.mark.parametrize("windows", [1, 8])
def test_a_line_is_missed_as_often_as_stated(amplitude, windows):
    """Truth: sines of known amplitude in complex normal noise of unit power; 5 % on each side, of 20000."""
    rng = np.random.default_rng(7)
    noise = rng.normal(size=(2, 20_000, windows)) * np.sqrt(0.5)
    ratio = np.mean((noise[0] + amplitude) ** 2 + noise[1] ** 2, axis=1)
    lower, upper = line_bounds(ratio, windows, 0.05)
    if amplitude:
        assert np.mean(amplitude**2 > upper) == pytest.approx(0.05, abs=0.006)
    assert np.mean(amplitude**2 < lower) == pytest.approx(0.05, abs=0.006)


@pytest.mark.parametrize("alpha", [1e-8, 1e-3, 0.05])
def test_bounds_are_quantiles_of_the_noncentral_distribution(alpha):
    ratio = np.array([1.5, 5.0, 40.0, 200.0])
    lower, upper = line_bounds(ratio, 8, alpha)
    some = lower > 0.0
    assert ncx2.sf(16.0 * ratio, 16, 16.0 * np.maximum(lower, 1e-9))[some] == pytest.approx(alpha, rel=0.25)
    some = upper > 0.0
    assert ncx2.cdf(16.0 * ratio, 16, 16.0 * np.maximum(upper, 1e-9))[some] == pytest.approx(alpha, rel=0.25)


def test_a_difference_of_densities_is_missed_as_often_as_stated():
    """Truth: chi-square values of known means, 3 and 2; 2.5 % on each side, of 20000."""
    rng = np.random.default_rng(8)
    own, other = 3.0 * rng.chisquare(30.0, 20_000) / 30.0, 2.0 * rng.chisquare(60.0, 20_000) / 60.0
    bounds = [(p, *power_bounds(p, np.full(p.size, dof), 0.025, 0.025)) for p, dof in ((own, 30.0), (other, 60.0))]
    value, lower, upper = difference_bounds(*bounds)
    assert value.mean() == pytest.approx(1.0, abs=0.02)
    assert np.mean(upper < 1.0) == pytest.approx(0.025, abs=0.012)
    assert np.mean(lower > 1.0) == pytest.approx(0.025, abs=0.012)
