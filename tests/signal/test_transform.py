"""The transform in parts, and what is made of it. Truth: NumPy's transform of the whole array."""

import numpy as np
import pytest

from mechid.signal import amplitude_spectrum, peak_groups, peak_spectrum, transform
from mechid.signal.transform import transform_blocks

RNG = np.random.default_rng(17)


@pytest.mark.parametrize("samples", [16, 27, 60, 64, 225, 1000, 1013])
@pytest.mark.parametrize("at_once", [8, 50, 2000])
def test_each_bin_comes_once_and_is_numpys(monkeypatch, samples, at_once):
    """In one, some, or many parts of odd and even lengths; 1013 is prime and has one part."""
    monkeypatch.setattr(transform, "PART_SAMPLES", at_once)
    monkeypatch.setattr(transform, "COLUMNS", 7)
    y = RNG.standard_normal(samples + 3) + 2.0
    numbers, bins = map(np.concatenate, zip(*transform_blocks(y, samples, mean=2.0), strict=True))
    order = np.argsort(numbers)
    assert numbers[order].tolist() == list(range(samples // 2 + 1))
    np.testing.assert_allclose(bins[order], np.fft.rfft(y[:samples] - 2.0), rtol=1e-10, atol=1e-11)


@pytest.mark.parametrize("samples", [100, 1001, 65_536, 600_001])
def test_the_peaks_are_those_of_the_whole_spectrum(samples):
    """600 001 samples are transformed as 600 000 in three parts; the other lengths but 1001 whole, that as 1000."""
    y = np.sin(0.37 * np.arange(samples)) + 0.1 * RNG.standard_normal(samples)
    size = 1000 if samples == 1001 else samples // 2 * 2
    frequency, amplitude = amplitude_spectrum(y[:size], 1e4)
    starts = peak_groups(amplitude.size, 300)
    found_hz, found = peak_spectrum(y, 1e4, 300)
    np.testing.assert_allclose(found, np.maximum.reduceat(amplitude, starts), rtol=1e-9)
    assert np.all((found_hz >= frequency[starts]) & (found_hz <= np.append(frequency[starts[1:]], frequency[-1])))


def test_a_lost_sample_leaves_no_spectrum():
    assert np.isnan(peak_spectrum(np.append(np.zeros(99), np.nan), 1e4, 300)[1]).all()
