"""Truth: sines put together by hand."""

import numpy as np
import pytest

from mechid.signal import order_amplitudes

ORDERS = (0.5, 1.0, 2.0)
AMPLITUDES = np.array([0.3 * np.exp(0.4j), 0.7 * np.exp(-2.0j), 0.01 * np.exp(3.0j)])


def synthetic(position, constant=0.2):
    return constant + sum((c * np.exp(2j * np.pi * o * position)).real for o, c in zip(ORDERS, AMPLITUDES, strict=True))


@pytest.mark.parametrize("rates", [(46.0, 46.0), (20.0, 60.0)], ids=["constant", "sweep"])
def test_amplitude_and_phase_come_back(rates):
    time = np.arange(5000) / 10_000.0
    position = rates[0] * time + (rates[1] - rates[0]) * time**2
    found, error = order_amplitudes(synthetic(position), position, ORDERS)
    np.testing.assert_allclose(found, AMPLITUDES, atol=1e-12)
    assert error < 1e-12


def test_the_error_is_what_noise_scatters_them_by():
    """Truth: the scatter over 400 draws, whose own error is 3.5 % over both parts."""
    rng, position = np.random.default_rng(8), np.arange(4000) / 100.0
    draws = [
        order_amplitudes(synthetic(position) + 0.05 * rng.standard_normal(4000), position, ORDERS) for _ in range(400)
    ]
    off = np.array([found - AMPLITUDES for found, _ in draws])
    scatter = np.sqrt(0.5 * np.mean(np.abs(off) ** 2, axis=0))
    np.testing.assert_allclose(scatter, np.mean([error for _, error in draws]), rtol=0.15)
