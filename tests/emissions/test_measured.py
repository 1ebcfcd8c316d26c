"""Definitions of the measured quantities. Truth: scipy.signal on the same samples, to 1e-6."""

import numpy as np
import pytest
from scipy.fft import irfft, rfft, rfftfreq
from scipy.signal import periodogram, welch

from mechid.emissions.band_peak import band_peaks
from mechid.emissions.lines import find_lines
from mechid.emissions.measured import Stretch, measure, sum_bins
from mechid.emissions.spectra import channel_spectra
from mechid.specification.requirement import Mask, Requirement

FS, N, LENGTH = 1000.0, 16000, 2000


@pytest.fixture(scope="module")
def y():
    time = np.arange(N) / FS
    return 0.3 * np.sin(2.0 * np.pi * 40.0 * time) + 0.1 * np.random.default_rng(5).normal(size=N) + 2.0


def stretch_of(y, background=None):
    spectra = channel_spectra(y, FS, LENGTH)
    beside = channel_spectra(background, FS, LENGTH) if background is not None else None
    return Stretch(
        y=y, rate=40.0, spectra=spectra, lines=find_lines(spectra), background=beside, background_y=background
    )


def wanted(kind, points=((20.0, 1.0), (100.0, 1.0), (300.0, 1.0)), **more):
    f, limits = np.array(points).T
    return Requirement(name="r", direction="fx", kind=kind, mask=Mask(f, limits, kind in ("rms", "band_peak")), **more)


def test_a_density_is_welchs(y):
    f, density = welch(y, FS, "hann", LENGTH, LENGTH // 2, detrend="constant")
    measured = measure(stretch_of(y), wanted("psd"), 1)
    inside = (f >= 20.0) & (f <= 300.0)
    assert measured.frequency_hz == pytest.approx(f[inside])
    assert measured.value == pytest.approx(density[inside], rel=1e-6)


def test_rms_is_the_root_of_the_densitys_sum(y):
    f, density = welch(y, FS, "hann", LENGTH, LENGTH // 2, detrend="constant")
    measured = measure(stretch_of(y), wanted("rms", ((20.25, 1.0), (100.25, 1.0), (300.25, 1.0))), 1)
    sums = [np.sqrt(np.sum(density[(f > a) & (f < b)]) * f[1]) for a, b in ((20.25, 100.25), (100.25, 300.25))]
    assert measured.value == pytest.approx(sums, rel=1e-6)
    assert measured.value[0] == pytest.approx(np.hypot(0.3 / np.sqrt(2.0), 0.1 * np.sqrt(80.0 / 500.0)), rel=0.01)


def test_third_octaves_are_those_of_base_ten(y):
    f, density = welch(y, FS, "hann", LENGTH, LENGTH // 2, detrend="constant")
    measured = measure(stretch_of(y), wanted("third_octave"), 1)
    assert measured.frequency_hz == pytest.approx(10.0 ** (np.arange(14, 25) / 10.0))
    ends, total = np.append(f - 0.25, f[-1] + 0.25), np.append(0.0, np.cumsum(density) * f[1])
    c = measured.frequency_hz
    sums = np.interp(c * 10**0.05, ends, total) - np.interp(c * 10**-0.05, ends, total)
    assert measured.value == pytest.approx(np.sqrt(sums), rel=1e-6)


def test_an_amplitude_is_the_peak_of_a_sine(y):
    """Truth: periodograms of the windows without overlap, scaled so that a sine reads its amplitude."""
    lines = find_lines(channel_spectra(y, FS, LENGTH))
    assert lines.frequency_hz.size == 1
    rows = [
        periodogram(y[k : k + LENGTH], FS, "hann", detrend="constant", scaling="spectrum") for k in range(0, N, LENGTH)
    ]
    spectrum = np.mean([2.0 * power for _, power in rows], axis=0)
    peak = spectrum[np.argmin(np.abs(rows[0][0] - 40.0))]
    biased = np.hypot(lines.amplitude[0] * lines.response[0], np.sqrt(lines.noise[0]))
    assert biased == pytest.approx(np.sqrt(peak), rel=1e-6)
    assert lines.amplitude[0] == pytest.approx(0.3, abs=4.0 * lines.sigma[0])


def test_a_band_peak_is_that_of_a_butterworth_filter(y):
    """Truth: the filter's response on the transform of the samples, padded until its ringing has died out."""
    low, high = 30.0, 60.0
    warped = np.tan(np.pi * np.array([low, high]) / FS)
    size = 4 * N
    with np.errstate(divide="ignore", invalid="ignore"):
        s = 1j * np.tan(np.pi * rfftfreq(size, 1.0 / FS) / FS)
        p = (s**2 + warped.prod()) / (s * np.ptp(warped))  # low-pass to band-pass
    poles = np.exp(1j * np.pi * (2.0 * np.arange(1, 5) + 3.0) / 8.0)
    with np.errstate(invalid="ignore"):
        response = np.prod([-pole / (p - pole) for pole in poles], axis=0)
    response = np.where(np.isfinite(response), response, 0.0)
    filtered = irfft(rfft(y - y.mean(), size) * response, size)[:N]
    peaks, rms = band_peaks(y, FS, [(low, high)])
    assert peaks[0] == pytest.approx(np.abs(filtered).max(), rel=1e-6)
    assert rms[0] == pytest.approx(np.sqrt(np.mean(filtered**2)), rel=1e-6)


def test_a_sum_of_bins_takes_parts_of_them():
    assert sum_bins(np.array([1.0, 2.0, 4.0]), 1.0, np.array([[0.5, 1.5], [1.25, 1.75]])) == pytest.approx([2.0, 1.5])


@pytest.mark.parametrize("kind", ["psd", "rms", "third_octave", "band_peak"])
def test_bounds_hold_the_truth(kind):
    """Truth: the same quantity of the emission without the background; at 95 % a bound fails at 1 in 40 frequencies."""
    rng = np.random.default_rng(3)
    time = np.arange(N) / FS
    missed, counted = 0, 0
    for _ in range(12):
        emission = 0.2 * np.sin(2.0 * np.pi * 40.0 * time + rng.uniform(0.0, 6.0))
        made = emission + 0.05 * rng.normal(size=N)
        truth = measure(stretch_of(emission + 1e-6 * rng.normal(size=N)), wanted(kind), 1).value
        found = measure(stretch_of(made, 0.05 * rng.normal(size=N)), wanted(kind), 1)
        missed += int(np.sum((truth > found.upper) | (truth < found.lower)))
        counted += truth.size
    assert missed <= 0.05 * counted + 2.0


def test_a_part_of_the_mask_outside_the_record_is_left_out(y):
    measured = measure(stretch_of(y), wanted("psd", ((20.0, 1.0), (4000.0, 1.0))), 1)
    assert measured.frequency_hz.max() <= FS / 2.56
