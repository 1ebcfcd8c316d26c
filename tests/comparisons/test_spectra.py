"""Residual spectra of compared fits. Truth: the power of a white noise and of a line, by hand."""

import numpy as np

from mechid.analysis.residual_emission import CENTRES_HZ, TRACKED, ResidualAtRate
from mechid.analysis.residual_file import ResidualRecord
from mechid.comparisons.spectra import WIDTH, band_rms

RATE, DENSITY, AMPLITUDE = 50.0, 1e-8, 0.02
FIRST = TRACKED.index(1.0)


def at(rate, amplitude=0.0, seconds=1.0, sigma=0.0):
    lines = np.zeros(len(TRACKED))
    lines[FIRST] = amplitude
    return ResidualAtRate(
        rate=rate,
        windows=1,
        duration_s=seconds,
        amplitude=lines,
        sigma=np.full(len(TRACKED), sigma),
        density=np.full(CENTRES_HZ.size, DENSITY),
    )


def record(*rates):
    return ResidualRecord(
        name="a", stepping="full", microsteps=1, noise_sigma=1e-3, sample_rate_hz=1e4, rates=tuple(rates)
    )


def test_a_density_gives_its_power_in_the_bands_width():
    rms = band_rms(record(at(RATE)), CENTRES_HZ)
    assert np.allclose(rms**2, DENSITY * WIDTH * CENTRES_HZ)


def test_a_line_stands_in_the_band_of_its_frequency():
    white = band_rms(record(at(RATE)), CENTRES_HZ)
    rms = band_rms(record(at(RATE, AMPLITUDE)), CENTRES_HZ)
    band = int(np.argmin(np.abs(np.log(CENTRES_HZ / RATE))))
    assert np.isclose(rms[band] ** 2 - white[band] ** 2, AMPLITUDE**2 / 2.0)
    assert np.allclose(np.delete(rms, band), np.delete(white, band))


def test_the_noise_of_a_line_is_not_counted_twice():
    assert np.allclose(band_rms(record(at(RATE, 1e-3, sigma=1e-3)), CENTRES_HZ), band_rms(record(at(RATE)), CENTRES_HZ))


def test_rates_count_by_how_long_they_lasted():
    rms = band_rms(record(at(RATE, AMPLITUDE, seconds=1.0), at(2.0 * RATE, 0.0, seconds=3.0)), CENTRES_HZ)
    band = int(np.argmin(np.abs(np.log(CENTRES_HZ / RATE))))
    assert np.isclose(rms[band] ** 2 - DENSITY * WIDTH * CENTRES_HZ[band], AMPLITUDE**2 / 8.0)


def test_a_band_that_no_window_resolves_is_unknown():
    unknown = at(RATE)
    unknown.density[:3] = np.nan
    assert np.isnan(band_rms(record(unknown), CENTRES_HZ)[:3]).all()
