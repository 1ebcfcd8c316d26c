"""Truth: SciPy's periodogram, sines of known frequency and amplitude, and the chance law of noise."""

import numpy as np
import pytest
from scipy.signal import periodogram

from mechid.signal.lines import LEAST_RATIO, prominence, spectral_lines
from mechid.signal.mains import mains_lines

RATE = 1000.0
SIZE = 20_000


def sine(frequency, amplitude, phase=0.3, size=SIZE):
    return amplitude * np.sin(2.0 * np.pi * frequency / RATE * np.arange(size) + phase)


def test_the_spectrum_is_scipys():
    y = np.random.default_rng(1).standard_normal(SIZE) + sine(46.0, 0.3)
    _, power = periodogram(y, RATE, window="hann", scaling="spectrum", detrend="constant")
    inside = slice(1, -1)  # SciPy halves no mean and no Nyquist bin of amplitudes
    assert prominence(y, RATE).amplitude[inside] == pytest.approx(np.sqrt(2.0 * power[inside]), rel=1e-9)


@pytest.mark.parametrize("off", [0.0, 0.2, 0.5, 0.8])
def test_a_line_between_bins_has_its_frequency_and_amplitude(off):
    frequency = 46.0 + off * RATE / SIZE
    y = sine(frequency, 0.5) + 1e-4 * np.random.default_rng(2).standard_normal(SIZE)
    (line,) = spectral_lines(prominence(y, RATE), 1e6)
    assert line.frequency_hz == pytest.approx(frequency, abs=1e-3 * RATE / SIZE)
    assert line.amplitude == pytest.approx(0.5, rel=1e-3)


def test_its_sigma_is_the_scatter_over_draws():
    """200 draws: a standard deviation is known to 5 %, and its mean to 7 % of it."""
    rng = np.random.default_rng(3)
    z = []
    for k in range(200):
        y = sine(46.01 + 0.0007 * k, 0.1, phase=k) + 0.5 * rng.standard_normal(SIZE)
        line = max(spectral_lines(prominence(y, RATE)), key=lambda found: found.amplitude)
        z.append((line.amplitude - 0.1) / line.sigma)
    assert np.std(z) == pytest.approx(1.0, abs=0.2)
    assert abs(np.mean(z)) < 0.3


@pytest.mark.parametrize("colour", [0.0, 0.95], ids=["white", "coloured"])
def test_noise_has_hardly_ever_a_line(colour):
    """A bin exceeds the ratio r with the chance 2^-r: none of 200 000 bins is expected above 30."""
    rng, found = np.random.default_rng(4), 0
    for _ in range(20):
        y = rng.standard_normal(SIZE)
        for k in range(1, SIZE if colour else 0):
            y[k] += colour * y[k - 1]
        found += len(spectral_lines(prominence(y, RATE), LEAST_RATIO))
    assert found <= 1


def test_hum_is_found_with_its_multiples_and_nothing_in_noise():
    rng = np.random.default_rng(5)
    noise = rng.standard_normal(SIZE)
    hum = sum(sine(50.03 * k, 0.2 / k, phase=k) for k in (1, 3, 5))
    lines = mains_lines(prominence(0.3 * noise + hum, RATE))
    assert [(line.mains_hz, line.multiple) for line in lines] == [(50.0, 1), (50.0, 3), (50.0, 5)]
    assert lines[0].line.frequency_hz == pytest.approx(50.03, abs=0.01)
    assert lines[0].line.amplitude == pytest.approx(0.2, abs=5.0 * lines[0].line.sigma)
    assert all(not mains_lines(prominence(rng.standard_normal(SIZE), RATE)) for _ in range(50))


def test_a_line_of_both_grids_is_the_one_that_shows_others():
    y = sine(60.0, 0.5) + sine(300.0, 0.4) + np.random.default_rng(6).standard_normal(SIZE)
    assert [(one.mains_hz, one.multiple) for one in mains_lines(prominence(y, RATE))] == [(60.0, 1), (60.0, 5)]


def test_lines_that_are_only_near_a_multiple_are_no_hum():
    """50.4 Hz is off the grid; 350 Hz alone may be anything."""
    noise = np.random.default_rng(7).standard_normal(SIZE)
    assert mains_lines(prominence(noise + sine(50.4, 1.0) + sine(350.0, 1.0), RATE)) == ()
