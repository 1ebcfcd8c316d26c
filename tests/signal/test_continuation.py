"""Continuation of a series. Truth: sines go on as they are; predictions of noise do not grow."""

import numpy as np
import pytest

from mechid.signal.continuation import burg_coefficients, continue_series


def test_sines_go_on():
    time = np.arange(6000)
    y = 3.0 + np.cos(0.05 * time) + 0.5 * np.sin(0.9 * time) + 0.2 * np.cos(2.1 * time + 1.0)
    assert np.abs(continue_series(y[:5000], 100) - y[5000:5100]).max() < 0.01


def test_noise_fades_to_its_mean():
    y = 2.0 + np.random.default_rng(1).normal(size=3000)
    found = continue_series(y, 4000)
    assert np.abs(found).max() < np.abs(y).max()
    assert found[-1] == pytest.approx(y.mean(), abs=0.05)


def test_the_coefficients_of_a_known_process():
    """Truth: y_k = 1.2 y_(k-1) - 0.6 y_(k-2) + e_k."""
    rng, y = np.random.default_rng(2), np.zeros(20_000)
    noise = rng.normal(size=y.size)
    for k in range(2, y.size):
        y[k] = 1.2 * y[k - 1] - 0.6 * y[k - 2] + noise[k]
    assert burg_coefficients(y, 2) == pytest.approx([1.0, -1.2, 0.6], abs=0.02)


@pytest.mark.parametrize("y", [np.zeros(20), np.full(3, 5.0), np.array([1.0])])
def test_what_is_constant_stays(y):
    assert continue_series(y, 4).tolist() == [y[0]] * 4
