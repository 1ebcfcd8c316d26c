"""Hann's window and the power density under it, against SciPy's."""

import numpy as np
import pytest
import scipy.signal

from mechid.signal.density import power_density
from mechid.signal.window import hann, windowed_density


@pytest.mark.parametrize("size", [1, 2, 3, 16, 401, 8192])
def test_window(size):
    np.testing.assert_allclose(hann(size), scipy.signal.windows.hann(size, sym=False), rtol=0.0, atol=1e-16)


@pytest.mark.parametrize("size", [16, 401, 4096])
def test_density_of_one_stretch(size):
    y = 3.0 + np.random.default_rng(0).standard_normal(size)
    frequency, truth = scipy.signal.periodogram(y, 1e4, window="hann")
    np.testing.assert_allclose(windowed_density(y, 1e4), truth, rtol=1e-10, atol=1e-12 * truth.max())
    np.testing.assert_allclose(np.arange(truth.size) * 1e4 / size, frequency)


@pytest.mark.parametrize("size", [64, 20_000, 150_001])
def test_welch(size):
    """In blocks of segments, all of them together."""
    y = np.cumsum(np.random.default_rng(1).standard_normal(size))
    frequency, density = power_density(y, 1e4)
    truth = scipy.signal.welch(y, 1e4, window="hann", nperseg=2 * (density.size - 1))
    np.testing.assert_allclose(frequency, truth[0])
    np.testing.assert_allclose(density, truth[1], rtol=1e-9, atol=1e-12 * truth[1].max())
