"""What a fit leaves of a torque: lines of known amplitude in white noise, and noise alone."""

import numpy as np
import pytest

from mechid.analysis.residual_emission import CENTRES_HZ, TRACKED, residual_emission

RATE_HZ, SIGMA = 4000.0, 2e-3


def noise(seed, seconds):
    return SIGMA * np.random.default_rng(seed).normal(size=round(seconds * RATE_HZ))


def test_a_line_in_noise_is_found_at_every_rate_of_a_sweep():
    """Truth: 1 mN m at order 3/4; the error of each amplitude is within four times what is stated."""
    t = np.arange(round(20.0 * RATE_HZ)) / RATE_HZ
    travel = 2.0 * t**2
    residual = noise(0, 20.0) + 1e-3 * np.cos(2.0 * np.pi * 0.75 * travel + 0.4)
    found = residual_emission(residual, travel, RATE_HZ)
    assert found[0].rate < 10.0
    assert found[-1].rate > 70.0
    at = TRACKED.index(0.75)
    for one in found[1:]:
        assert one.amplitude[at] == pytest.approx(1e-3, abs=4.0 * one.sigma[at] / np.sqrt(one.windows))
        assert one.sigma[at] < 3e-4


def test_noise_alone_is_as_large_as_is_stated():
    """Truth: the ratio of the powers is 1 on average, and the density between the lines that of white noise."""
    travel = 40.0 * np.arange(round(10.0 * RATE_HZ)) / RATE_HZ
    (found,) = residual_emission(noise(1, 10.0), travel, RATE_HZ)
    known = np.isfinite(found.amplitude)
    ratio = (found.amplitude[known] / found.sigma[known]) ** 2
    assert ratio.mean() == pytest.approx(1.0, abs=4.0 / np.sqrt(found.windows * ratio.size))
    wide = np.isfinite(found.density) & (CENTRES_HZ > 100.0) & (CENTRES_HZ < 1500.0)
    assert found.density[wide].mean() == pytest.approx(2.0 * SIGMA**2 / RATE_HZ, rel=0.05)


def test_orders_that_a_short_record_does_not_tell_apart_are_not_given():
    travel = 5.0 * np.arange(round(1.0 * RATE_HZ)) / RATE_HZ
    (found,) = residual_emission(noise(2, 1.0), travel, RATE_HZ)
    assert np.isnan(found.amplitude[TRACKED.index(0.25)])
    assert np.isfinite(found.amplitude[TRACKED.index(8.0)])


def test_a_record_that_does_not_travel_has_none():
    assert residual_emission(noise(3, 1.0), np.zeros(round(RATE_HZ)), RATE_HZ) == ()
