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


def hum(seconds, size, hz=50.02, drift_hz=0.0):
    """Return hum with its second and third multiple, of half and a third of its size."""
    t = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    turns = (hz - 0.5 * drift_hz) * t + 0.5 * drift_hz / seconds * t**2
    return size * sum(np.cos(2.0 * np.pi * k * turns + k) / k for k in (1, 2, 3))


@pytest.mark.parametrize("drift_hz", [0.0, 0.02])
@pytest.mark.parametrize("declared_hz", [50.0, 50.02, 49.95])
def test_hum_at_a_steady_rate_is_no_emission(declared_hz, drift_hz):
    """Truth: hum of 50.02 Hz and a line at order 2; noise alone elsewhere, and the density that of noise."""
    travel = 43.0 * np.arange(round(20.0 * RATE_HZ)) / RATE_HZ
    line = 1e-3 * np.cos(2.0 * np.pi * 2.0 * travel)
    hummed = noise(4, 20.0) + line + hum(20.0, 5e-3, drift_hz=drift_hz)
    (found,) = residual_emission(hummed, travel, RATE_HZ, declared_hz)
    (plain,) = residual_emission(noise(4, 20.0) + line, travel, RATE_HZ)
    np.testing.assert_allclose(found.amplitude, plain.amplitude, atol=1e-4, equal_nan=True)
    known = np.isfinite(plain.density)
    np.testing.assert_allclose(found.density[known], plain.density[known], rtol=0.2)
    (left,) = residual_emission(hummed, travel, RATE_HZ)
    assert np.nanmax(left.density / plain.density) > 5.0


@pytest.mark.parametrize("rate", [50.02 / 1.5, 33.3467, 50.02, 25.012])
def test_an_order_that_coincides_with_the_mains_is_not_known(rate):
    """Truth: hum at that order, which is nobody's emission; the other orders are as without it."""
    travel = rate * np.arange(round(20.0 * RATE_HZ)) / RATE_HZ
    (found,) = residual_emission(noise(5, 20.0) + hum(20.0, 1.46e-3), travel, RATE_HZ, 50.02)
    (plain,) = residual_emission(noise(5, 20.0), travel, RATE_HZ)
    off = np.array(TRACKED) * rate
    at = np.min(np.abs(off[:, None] - 50.02 * np.arange(1, 20)), axis=1) < 0.1
    assert at.any()
    assert np.all(np.isnan(found.amplitude[at]))
    np.testing.assert_allclose(found.amplitude[~at], plain.amplitude[~at], atol=1e-4, equal_nan=True)


def test_orders_of_a_sweep_that_cross_the_mains_stay():
    """Truth: a line at order 3/4 which passes 50 Hz at 67 steps/s; as without hum."""
    t = np.arange(round(20.0 * RATE_HZ)) / RATE_HZ
    travel = 2.0 * t**2
    residual = noise(6, 20.0) + 1e-3 * np.cos(2.0 * np.pi * 0.75 * travel)
    plain = residual_emission(residual, travel, RATE_HZ)
    found = residual_emission(residual + hum(20.0, 3e-3), travel, RATE_HZ, 50.0)
    at = TRACKED.index(0.75)
    for one, other in zip(found[1:], plain[1:], strict=True):
        assert one.amplitude[at] == pytest.approx(1e-3, abs=4.0 * one.sigma[at] / np.sqrt(one.windows))
        np.testing.assert_allclose(one.amplitude, other.amplitude, atol=1.5e-4, equal_nan=True)
