"""Length of a confirming record. Truth: the RMS of drawn lines in drawn white noise, many times."""

import numpy as np
import pytest

from mechid.quiet_drives.confirmation import confirm, noise_density
from mechid.quiet_drives.improvement import LineAt


@pytest.mark.parametrize("size", [1e-3, 1e-5])
def test_after_its_length_the_rms_is_known_to_one_decibel(size):
    rng = np.random.default_rng(3)
    density, count, sample_rate_hz = 1e-8, 20, 500.0
    amplitude = size * rng.uniform(0.2, 1.0, count)
    (found,) = confirm([LineAt(30.0, k + 1.0, a, a) for k, a in enumerate(amplitude)], density)
    # Lines in bins of the record; the noise of one bin, as 2/N times the transform of white samples.
    samples = found.seconds * sample_rate_hz
    sigma = np.sqrt(0.5 * density * sample_rate_hz)
    noise = sigma * np.sqrt(2.0 / samples) * rng.normal(size=(4000, count, 2)) @ [1.0, 1j]
    square = 0.5 * np.sum(np.abs(amplitude + noise) ** 2, axis=1) - count * density / found.seconds
    truth = 0.5 * np.sum(amplitude**2)
    assert np.quantile(np.abs(square / truth - 1.0), 0.95) == pytest.approx(10.0**0.1 - 1.0, rel=0.08)


def test_the_noise_is_that_of_the_records(fit):
    assert noise_density(fit) is None  # a fit without its records
    assert confirm([LineAt(30.0, 1.0, 1e-3, 1e-3)], None) == ()
