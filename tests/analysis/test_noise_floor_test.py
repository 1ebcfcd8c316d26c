"""A residual beside the noise. Truth: seeded white noise, and a line of known size in it."""

import math

import numpy as np
import pytest

from mechid.analysis.noise_floor_test import NoiseComparison, NoiseLevel, most_by_chance
from mechid.signal import amplitude_spectrum, effective_samples, effective_samples_of, noise_floor

RATE_HZ = 1e4
N = 10_001


def residual_of(r, floor=None):
    return NoiseComparison(
        residual_rms=float(np.sqrt(np.mean(r**2))),
        noise_sigma=noise_floor(r, RATE_HZ) if floor is None else floor,
        samples=r.size,
        effective_samples=effective_samples(r),
        floor_samples=r.size,
    )


@pytest.mark.parametrize(("samples", "draws"), [(1001, 200), (N, 200), (100_001, 20)])
def test_white_noise_is_noise(samples, draws):
    """By the normal law one of 30 000 is above; the floor, the least of several, makes it up to 5 of 1000."""
    rng = np.random.default_rng(31)
    levels = [residual_of(rng.standard_normal(samples)).level for _ in range(draws)]
    assert levels.count(NoiseLevel.NOISE) >= 0.98 * draws


@pytest.mark.parametrize(("factor", "level"), [(1.03, NoiseLevel.NOISE), (1.16, NoiseLevel.ABOVE)])
def test_ten_thousand_white_samples_are_judged_by_their_number(factor, level):
    """1.16 is 8.7 standard errors above 1: 0.7 % of the RMS and 1.7 % of the floor."""
    r = np.random.default_rng(32).standard_normal(N)
    r *= factor / np.sqrt(np.mean(r**2))
    found = residual_of(r, floor=1.0)
    assert found.level is level
    error = math.hypot(math.sqrt(0.5 / found.effective_samples), 1.7 / math.sqrt(N))
    assert (found.most_by_chance - 1.0) / error == pytest.approx(4.0)


def test_a_line_that_the_model_misses_is_no_noise_though_it_leaves_few_effective_samples():
    t = np.arange(N) / RATE_HZ
    r = np.random.default_rng(33).standard_normal(N) + 0.83 * np.sin(2.0 * np.pi * 46.0 * t)
    found = residual_of(r, floor=1.0)
    assert found.ratio == pytest.approx(math.sqrt(1.0 + 0.83**2 / 2.0), rel=0.02)
    assert found.effective_samples < 100
    assert found.level is NoiseLevel.COLOURED
    assert not found.is_noise


def test_few_samples_excuse_no_more_than_what_the_search_calls_a_misfit():
    assert most_by_chance(1.0, N) == most_by_chance(math.nan, N) == 1.2


def test_a_run_that_is_lost_has_no_level():
    lost = NoiseComparison(
        residual_rms=math.nan, noise_sigma=1.0, samples=N, effective_samples=math.nan, floor_samples=N
    )
    assert lost.level is NoiseLevel.LOST


@pytest.mark.parametrize("samples", [3000, 3001])
def test_effective_samples_from_a_spectrum_are_those_of_the_series(samples):
    r = np.random.default_rng(34).standard_normal(samples)
    r -= r.mean()
    trimmed = r[:3000]  # `effective_samples` leaves out what makes the transform slow
    spectrum = amplitude_spectrum(trimmed, RATE_HZ)[1]
    found = effective_samples_of(spectrum, trimmed.size) * samples / 3000
    assert found == pytest.approx(effective_samples(r), rel=1e-6)
