"""Order analysis against signals and diagrams known in closed form."""

import numpy as np
import pytest

from mechid.budgets.orders import OrderMap, crossings, phasors, rates_to_avoid


def test_lines_between_bins_of_the_transform():
    """Truth: the amplitudes and phases put in, beside an offset; none falls on a bin."""
    t = np.arange(1237) / 1000.0
    y = 0.7 + 2.0 * np.cos(2 * np.pi * 11.5 * t + 0.4) + 0.5 * np.cos(2 * np.pi * 23.0 * t - 2.0)
    got = phasors(y, 1000.0, np.array([11.5, 23.0]))
    np.testing.assert_allclose(got, [2.0 * np.exp(0.4j), 0.5 * np.exp(-2.0j)], rtol=1e-10)


def test_crossings_of_a_campbell_diagram():
    """Truth: rate = frequency / order. 46 Hz is met by order 2 at 23, by 1 at 46 and by 1/2 at 92 steps/s."""
    found = crossings([0.5, 1.0, 2.0, 4.0], [("gear", 46.0)], (20.0, 120.0))
    assert [(c.order, c.rate) for c in found] == [(2.0, 23.0), (1.0, 46.0), (0.5, 92.0)]


def test_rates_to_avoid_are_interpolated():
    """Truth: the triangle 0, 2, 0 is above 1 in its middle half; the end is above to the end."""
    got = list(rates_to_avoid(np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 2.0, 0.0, 4.0]), 1.0))
    assert got == [(0.5, 1.5), (2.25, 3.0)]


def test_the_envelope_is_the_largest_at_any_rate():
    lines = np.array([[1.0, 0.5], [0.2, 3.0]], dtype=complex)
    order_map = OrderMap(np.array([10.0, 20.0]), np.array([1.0, 2.0]), lines)
    np.testing.assert_array_equal(order_map.envelope(np.array([5.0, 15.0, 30.0, 50.0])), [1.0, 0.5, 3.0])
    assert order_map.frequency_hz == pytest.approx(np.array([[10.0, 20.0], [20.0, 40.0]]))
