"""Truth: flat noise, a sine of known power, and the standard's band edges."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import welch

from mechid.signal import power_density, third_octaves
from mechid.signal.density import rms_below

RATE = 10_000.0


def test_white_noise_is_flat_at_twice_its_variance_over_the_rate():
    y = 0.002 * np.random.default_rng(3).standard_normal(200_000)
    _, density = power_density(y, RATE)
    assert np.mean(density[2:-2]) == pytest.approx(2.0 * 0.002**2 / RATE, rel=0.01)


@pytest.mark.parametrize("size", [16, 10_001, 600_001])
def test_its_integral_is_the_variance(size):
    y = np.random.default_rng(4).standard_normal(size)
    frequency, density = power_density(y, RATE)
    assert frequency[-1] == pytest.approx(RATE / 2.0)
    assert np.sum(density) * frequency[1] == pytest.approx(np.var(y), rel=4.0 / math.sqrt(size) + 0.02)


def test_a_sine_lies_in_its_band_with_its_rms():
    """The band of nominally 800 Hz is 707.9 to 891.3 Hz about 794.3 Hz (IEC 61260-1, base ten)."""
    y = 0.5 * np.sin(2.0 * np.pi * 800.0 / RATE * np.arange(100_000))
    bands = third_octaves(*power_density(y, RATE))
    band = next(b for b in bands if b.lower_hz < 800.0 < b.upper_hz)
    assert (round(band.lower_hz, 1), round(band.centre_hz, 1), round(band.upper_hz, 1)) == (707.9, 794.3, 891.3)
    assert band.rms == pytest.approx(0.5 / math.sqrt(2.0), rel=1e-3)
    assert sum(b.rms**2 for b in bands if b is not band) < 1e-6


def test_bands_of_a_flat_density_are_as_wide_as_they_say():
    frequency = np.arange(513) * RATE / 1024.0
    for band in third_octaves(frequency, np.full(513, 3.0)):
        assert band.rms**2 == pytest.approx(3.0 * (band.upper_hz - band.lower_hz))


def test_bands_leave_no_gap_up_to_half_the_rate():
    bands = third_octaves(*power_density(np.random.default_rng(5).standard_normal(10_001), RATE))
    for lower, upper in pairwise(bands):
        assert lower.upper_hz == pytest.approx(upper.lower_hz)
    assert bands[-1].upper_hz <= RATE / 2.0
    assert bands[-1].centre_hz * 10.0**0.1 >= RATE / 2.0


@pytest.mark.parametrize("size", [10_000, 100_000])
def test_it_is_scipys(size):
    """The segments are 4096 and 8192 samples long, those that are half a record at most."""
    y = np.random.default_rng(6).standard_normal(size)
    whole = welch(y, RATE, window="hann", nperseg=4096 if size == 10_000 else 8192)
    assert power_density(y, RATE)[1] == pytest.approx(whole[1], rel=1e-9)


def test_bands_and_what_is_below_make_up_the_whole():
    """Parseval: together they are the density's integral, which is the variance of a stationary series."""
    rng = np.random.default_rng(7)
    y = rng.standard_normal(200_000) + np.sin(2.0 * np.pi * 50.0 / RATE * np.arange(200_000))
    frequency, density = power_density(y, RATE)
    bands = third_octaves(frequency, density)
    total = sum(band.rms**2 for band in bands) + rms_below(frequency, density, bands) ** 2
    width = np.full(density.size, frequency[1])
    width[[0, -1]] /= 2.0
    assert total == pytest.approx(float(np.sum(density * width)), rel=1e-9)
    assert total == pytest.approx(np.var(y), rel=0.02)
