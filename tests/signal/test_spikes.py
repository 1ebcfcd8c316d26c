"""Spikes. Truth: those that were planted, also where one block of samples meets the next."""

import numpy as np
import pytest

from mechid.signal.series import BLOCK
from mechid.signal.spikes import isolated_spikes, outliers

SIGMA = 0.01
PLANTED = np.array([3, 40, 1000, BLOCK - 1, BLOCK + 30, 2 * BLOCK, 2 * BLOCK + 6])


def series(samples):
    noise = SIGMA * np.random.default_rng(29).standard_normal(samples)
    return np.sin(0.01 * np.arange(samples)) + noise


@pytest.mark.parametrize("samples", [2 * BLOCK + 10, 3 * BLOCK])
def test_single_samples_far_off_a_smooth_signal_are_found_and_no_others(samples):
    y = series(samples)
    y[PLANTED] += 0.5
    assert isolated_spikes(y, SIGMA).tolist() == PLANTED.tolist()


def test_a_short_series_has_no_spikes():
    assert isolated_spikes(np.append(np.zeros(49), 1.0), SIGMA).size == 0


def test_outliers_are_those_beyond_the_limit():
    residual = SIGMA * np.random.default_rng(31).standard_normal(3 * BLOCK + 5)
    residual[PLANTED] = -7.0 * SIGMA
    before = residual.copy()
    assert outliers(residual, 6.0).tolist() == PLANTED.tolist()
    assert np.array_equal(residual, before)
