"""Noise levels of spectra. Truth: the density of the noise that was made."""

import numpy as np
import pytest

from mechid.emissions.spectra import channel_spectra, noise_level, usable_band, window_length

FS = 1000.0


def test_the_level_is_that_of_the_noise_beneath_lines():
    """Truth: white noise of 0.1 over 500 Hz is 2e-5 a hertz; lines at every 4 Hz fill a third of the bins."""
    rng = np.random.default_rng(1)
    time = np.arange(40_000) / FS
    y = 0.1 * rng.normal(size=time.size) + sum(0.2 * np.sin(2.0 * np.pi * f * time) for f in np.arange(4.0, 400.0, 4.0))
    spectra = channel_spectra(y, FS, 4000)
    assert np.median(spectra.noise[40:1600]) == pytest.approx(2e-5, rel=0.3)


def test_the_level_of_noise_alone_is_its_mean():
    density = np.random.default_rng(2).chisquare(20.0, size=20_000) / 20.0
    assert np.mean(noise_level(density, 20.0)) == pytest.approx(1.0, rel=0.02)


def test_the_level_follows_colour():
    """Truth: noise whose density falls as 1 / f."""
    f = np.arange(1, 4001)
    density = np.random.default_rng(3).chisquare(40.0, size=f.size) / 40.0 / f
    ratio = noise_level(np.append(1.0, density), 40.0)[20:] * f[19:]
    assert ratio.mean() == pytest.approx(1.0, rel=0.03)
    assert np.abs(ratio - 1.0).max() < 0.5


def test_windows_are_eight_or_four_seconds_long():
    assert window_length(8000, FS) == 1000
    assert window_length(80_000, FS) == 4000
    assert usable_band(0.25, FS) == pytest.approx((0.75, 390.625))


def test_mains_are_found():
    time = np.arange(16_000) / FS
    y = sum(0.1 * np.sin(2.0 * np.pi * f * time) for f in (50.0, 150.0)) + 0.01 * np.random.default_rng(4).normal(
        size=time.size
    )
    found = channel_spectra(y, FS, 2000).mains
    assert [(one.mains_hz, one.multiple) for one in found] == [(50.0, 1), (50.0, 3)]
