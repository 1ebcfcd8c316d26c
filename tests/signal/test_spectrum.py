"""Spectra against closed forms: sums of sines whose amplitudes are known."""

import numpy as np
import pytest

from mechid.errors import UsageError
from mechid.signal import amplitude_spectrum, line_amplitude
from mechid.signal.spectrum import WINDOWS

RATE = 1000.0


def two_sines(samples):
    """0.5 + 2 sin at 50 Hz + 0.25 cos at 120 Hz."""
    time = np.arange(samples) / RATE
    return 0.5 + 2.0 * np.sin(2.0 * np.pi * 50.0 * time) + 0.25 * np.cos(2.0 * np.pi * 120.0 * time)


@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("samples", [1000, 1100, 2000])
def test_a_sine_on_a_bin_reads_its_amplitude(window, samples):
    frequency, amplitude = amplitude_spectrum(two_sines(samples), RATE, window)
    at = [int(np.argmin(np.abs(frequency - wanted))) for wanted in (0.0, 50.0, 120.0)]
    assert frequency[at] == pytest.approx([0.0, 50.0, 120.0], rel=1e-12)
    assert amplitude[at] == pytest.approx([0.5, 2.0, 0.25], rel=1e-12)


@pytest.mark.parametrize(("samples", "top"), [(8, 500.0), (9, 4.0 / 9.0 * 1000.0)])
def test_the_frequencies_go_up_to_nyquist(samples, top):
    frequency, _ = amplitude_spectrum(np.zeros(samples), RATE)
    assert frequency[0] == 0.0
    assert frequency[-1] == pytest.approx(top)


def test_an_alternating_sequence_reads_its_amplitude_at_nyquist():
    _, amplitude = amplitude_spectrum(np.tile([3.0, -3.0], 50), RATE)
    assert amplitude[-1] == pytest.approx(3.0)
    assert amplitude[:-1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("samples", [1000, 1001])
def test_energy_is_kept(samples):
    """Parseval: the mean square is that of the sines, half their squared amplitudes."""
    y = np.random.default_rng(1).normal(size=samples)
    _, amplitude = amplitude_spectrum(y, RATE)
    square = amplitude**2 / 2.0
    square[0] *= 2.0
    if samples % 2 == 0:
        square[-1] *= 2.0
    assert square.sum() == pytest.approx(np.mean(y**2), rel=1e-12)


def test_an_unknown_window_is_refused():
    with pytest.raises(UsageError, match='unknown window "han"; did you mean "hann"'):
        amplitude_spectrum(np.zeros(8), RATE, "han")


@pytest.mark.parametrize("bin_number", [1, 46, 117])
def test_a_line_on_a_bin_is_that_bin(bin_number):
    """Twin: the discrete Fourier transform."""
    y = np.random.default_rng(2).normal(size=500)
    frequency, amplitude = amplitude_spectrum(y, RATE)
    line = line_amplitude(y, RATE, frequency[bin_number])
    assert line == pytest.approx(amplitude[bin_number], rel=1e-10)


@pytest.mark.parametrize("frequency", [3.3, 46.123, 487.9])
@pytest.mark.parametrize("phase", [0.0, 1.0, 2.5])
def test_a_line_between_bins_is_exact(frequency, phase):
    y = 7.0 + 0.3 * np.sin(2.0 * np.pi * frequency * np.arange(777) / RATE + phase)
    assert line_amplitude(y, RATE, frequency) == pytest.approx(0.3, rel=1e-9)


@pytest.mark.parametrize("frequency", [0.0, 500.0, -1.0])
def test_a_line_outside_the_band_is_refused(frequency):
    with pytest.raises(UsageError, match=r"is not between 0 and 500\.0 Hz"):
        line_amplitude(np.zeros(100), RATE, frequency)
