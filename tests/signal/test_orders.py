"""Truth: sines put together by hand."""

import numpy as np
import pytest

from mechid.signal import order_amplitudes
from mechid.signal.orders import fit_orders

ORDERS = (0.5, 1.0, 2.0)
AMPLITUDES = np.array([0.3 * np.exp(0.4j), 0.7 * np.exp(-2.0j), 0.01 * np.exp(3.0j)])


def synthetic(position, constant=0.2):
    return constant + sum((c * np.exp(2j * np.pi * o * position)).real for o, c in zip(ORDERS, AMPLITUDES, strict=True))


@pytest.mark.parametrize("rates", [(46.0, 46.0), (20.0, 60.0)], ids=["constant", "sweep"])
def test_amplitude_and_phase_come_back(rates):
    time = np.arange(5000) / 10_000.0
    position = rates[0] * time + (rates[1] - rates[0]) * time**2
    both = np.column_stack((synthetic(position), 2.0 * synthetic(position)))
    found, error = order_amplitudes(both, position, ORDERS)
    np.testing.assert_allclose(found, np.outer(AMPLITUDES, (1.0, 2.0)), atol=1e-12)
    assert np.all(error < 1e-12)


def test_the_error_is_what_noise_scatters_them_by():
    """Truth: the scatter over 400 draws, whose own error is 3.5 % over both parts."""
    rng, position = np.random.default_rng(8), np.arange(4000) / 100.0
    noise = 0.05 * rng.standard_normal((4000, 400))
    found, errors = order_amplitudes(synthetic(position)[:, None] + noise, position, ORDERS)
    scatter = np.sqrt(0.5 * np.mean(np.abs(found - AMPLITUDES[:, None]) ** 2, axis=1))
    np.testing.assert_allclose(scatter, np.mean(errors), rtol=0.15)


def test_they_are_the_best_fit_where_the_travel_just_tells_them_apart():
    """Truth: NumPy's least squares of all sines, of 28 orders a quarter apart over nine of their cycles."""
    orders = np.arange(1, 29) / 4.0
    position = 9.0 * np.linspace(0.0, 1.0, 3000) ** 1.1
    y = np.random.default_rng(3).standard_normal((3000, 2))
    angle = 2.0 * np.pi * np.outer(position, orders)
    columns = np.column_stack((np.ones(3000), np.cos(angle), np.sin(angle)))
    best = np.linalg.lstsq(columns, y, rcond=None)[0]
    amplitudes, left = fit_orders(y, position, orders)
    np.testing.assert_allclose(amplitudes, best[1:29] - 1j * best[29:], atol=1e-12)
    np.testing.assert_allclose(left, y - columns @ best, atol=1e-12)
