"""Decimation against closed forms: what passes is the signal at its own instants, what folds is gone."""

import numpy as np
import pytest

from mechid.signal import noise_floor
from mechid.signal.decimation import PASS, STOP, anti_alias_filter, decimate

RIPPLE = 2e-5
"""100 dB, and as much for rounding the filter's length."""
SAMPLES = 20000


def sine(share, factor, samples=SAMPLES):
    """A sine at a share of the result's Nyquist frequency."""
    return np.sin(np.pi * share / factor * np.arange(samples) + 0.4)


@pytest.mark.parametrize("factor", [2, 3, 5, 10])
@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.8, PASS])
def test_a_sine_in_the_pass_band_is_sampled_at_its_own_instants(factor, share):
    inner = slice(200, -200)
    found = decimate(sine(share, factor), factor)
    np.testing.assert_allclose(found[inner], sine(share, factor)[::factor][inner], atol=RIPPLE)


@pytest.mark.parametrize("factor", [2, 5, 10])
@pytest.mark.parametrize("share", [STOP, 1.3, 1.9])
def test_a_sine_that_would_fold_back_is_gone(factor, share):
    assert np.abs(decimate(sine(share, factor), factor)[200:-200]).max() < RIPPLE


@pytest.mark.parametrize("factor", [2, 7])
def test_a_straight_line_passes_to_both_ends(factor):
    line = 3.0 - 2e-3 * np.arange(5000)
    np.testing.assert_allclose(decimate(line, factor), line[::factor], atol=1e-10)


@pytest.mark.parametrize(("samples", "factor"), [(5000, 7), (5001, 7), (5006, 7), (1000, 2)])
def test_every_so_manieth_sample_is_kept_from_the_first_on(samples, factor):
    assert decimate(np.zeros(samples), factor).size == len(range(0, samples, factor))


def test_the_filter_is_symmetric_and_of_unit_gain():
    taps = anti_alias_filter(5)
    np.testing.assert_array_equal(taps, taps[::-1])
    assert taps.sum() == pytest.approx(1.0, abs=1e-12)


def test_white_noise_keeps_its_density():
    """Its variance falls by the factor; the noise floor is read in the part that the filter leaves."""
    noise = np.random.default_rng(5).normal(size=200_000)
    assert decimate(noise, 5).std() == pytest.approx(1.0 / np.sqrt(5.0), rel=0.02)
    assert noise_floor(decimate(noise, 5), 2000.0) == pytest.approx(1.0 / np.sqrt(5.0), rel=0.05)
