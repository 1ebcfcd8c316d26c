"""Clipped, quiet and coarse series. Truth: what the test has put in."""

import numpy as np
import pytest

from mechid.signal.clipping import clipped_runs
from mechid.signal.quiet_stretches import quiet_stretches
from mechid.signal.resolution import resolution

RATE = 10_000.0


def test_clipped_peaks_are_found_at_both_ends():
    y = np.clip(np.sin(2.0 * np.pi * 5.0 * np.arange(10_000) / RATE), -0.9, 0.95)
    runs = clipped_runs(y)
    assert len(runs) == 10
    assert all(np.all((y[first:stop] == 0.95) | (y[first:stop] == -0.9)) for first, stop in runs)
    assert clipped_runs(np.sin(np.arange(1000.0))) == ()


@pytest.mark.parametrize("step", [1.0, 0.002, 2.0**-15, 1.8 / 50.0])
def test_the_step_of_a_converter_is_read_whatever_its_offset(step):
    y = 0.123 + step * np.rint(40.0 * np.sin(0.01 * np.arange(20_000)))
    assert resolution(y) == pytest.approx(step, rel=1e-6)


def test_noise_without_a_step_has_none():
    assert resolution(np.random.default_rng(1).standard_normal(10_000)) == 0.0
    assert resolution(np.zeros(100)) == 0.0
    assert resolution(np.sin(np.arange(1000.0))) == 0.0


def test_a_quiet_stretch_has_its_place_and_its_rms():
    rng = np.random.default_rng(2)
    y = 0.002 * rng.standard_normal(30_000) + 0.3
    y[5_000:20_000] += np.sin(0.05 * np.arange(15_000))
    first, second = quiet_stretches(y, RATE)
    assert (first.first, first.stop) == (0, 5_000)
    assert (second.first, second.stop) == (20_000, 30_000)
    assert second.rms == pytest.approx(0.002, rel=0.05)


def test_a_signal_that_never_rests_has_no_quiet_stretch():
    assert quiet_stretches(np.random.default_rng(3).standard_normal(10_000), RATE) == ()
    assert quiet_stretches(np.sin(0.05 * np.arange(10_000)), RATE) == ()
    assert quiet_stretches(np.ones(20), RATE) == ()
    assert quiet_stretches(np.arange(10_000.0), RATE) == ()
