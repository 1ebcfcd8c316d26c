"""Where in frequency most of a series lies."""

import numpy as np
import pytest

from mechid.signal.density import average_in_groups, power_density
from mechid.signal.strongest import find_strongest

RATE_HZ = 2000.0
TIME_S = np.arange(8000) / RATE_HZ


def test_the_lines_of_a_series_by_their_size():
    """Truth: the sines that make the series; the least has a hundredth of the largest one's power."""
    sizes = {47.3: 1.0, 211.0: 3.0, 92.1: 2.0, 400.0: 0.3, 18.0: 0.2}
    found = find_strongest(sum(a * np.sin(2 * np.pi * hz * TIME_S) for hz, a in sizes.items()), RATE_HZ)
    assert found.in_lines
    assert found.frequencies_hz == pytest.approx([211.0, 92.1, 47.3], rel=1e-3)


def test_a_sweep_has_a_band():
    """Truth: a sine that sweeps from 70 to 90 Hz lies within the third octave at 80 Hz."""
    phase = 2 * np.pi * (70.0 * TIME_S + 0.5 * 5.0 * TIME_S**2)
    found = find_strongest(np.sin(phase), RATE_HZ)
    assert not found.in_lines
    assert found.frequencies_hz[0] == pytest.approx(79.4, rel=0.01)


def test_nothing_has_no_frequencies():
    assert find_strongest(np.zeros(1000), RATE_HZ).frequencies_hz == ()


def test_groups_keep_the_power():
    """Truth: the density of the same bins, summed."""
    frequency, density = power_density(np.random.default_rng(3).normal(size=8000), RATE_HZ)
    starts_hz, mean = average_in_groups(frequency, density, 40)
    assert mean.size <= 40
    assert np.all(np.diff(starts_hz) > 0.0)
    assert average_in_groups(frequency, density, density.size)[1] == pytest.approx(density[1:])
    assert mean == pytest.approx(np.full(mean.size, 2.0 / RATE_HZ), rel=1.0)
