"""Lines that a mechanism names. Truth: the sines put into the samples, at published orders of a solar array drive."""

import numpy as np
import pytest

from mechid.analysis.look import MORE_ORDERS
from mechid.analysis.named_orders import named_orders
from mechid.analysis.residual_emission import TRACKED, residual_emission, tracked_orders
from mechid.plant.mechanism import NamedLine

STEPS = 200 * 184
"""Full steps of a rotor of 200 steps behind a ratio of 184 in a turn of the array."""
PUBLISHED = {"mesh 1": 13616.0, "mesh 2": 14800.0, "wheel 2": 184.0, "wheel 3": 197.0 + 1.0 / 3.0, "wheel 4": 185.0}
SIZES = {"mesh 1": 0.003, "mesh 2": 0.002, "wheel 2": 0.004, "wheel 3": 0.005, "wheel 4": 0.003}
NAMED = [NamedLine(name, name, order / 184.0, order / STEPS) for name, order in PUBLISHED.items()]
RATE_HZ = 400.0
TURN_S = 200.0


def record(turns=1.0, sizes=SIZES, noise=0.01):
    """Return travel and torque of an array that turns in 200 s, with a strong line of the steps."""
    time = np.arange(round(turns * TURN_S * RATE_HZ)) / RATE_HZ
    array = time / TURN_S
    torque = noise * np.random.default_rng(3).standard_normal(time.size)
    torque += 0.05 * np.sin(2 * np.pi * STEPS * array / 2)
    for name, size in sizes.items():
        torque += size * np.sin(2 * np.pi * PUBLISHED[name] * array + PUBLISHED[name])
    return STEPS * array, torque


def test_one_turn_of_the_array_shows_all_lines_apart():
    """Truth: five sines of 2 to 5 mN m under 10 mN m of noise, the closest one order apart; errors within 4 sigma."""
    travel, torque = record()
    found = named_orders(torque, travel, RATE_HZ, NAMED, MORE_ORDERS).lines
    assert [one.names for one in sorted(found, key=lambda one: one.position)] == [(name,) for name in PUBLISHED]
    for one in found:
        assert abs(abs(one.amplitude) - SIZES[one.names[0]]) < 4.0 * one.noise / np.sqrt(2.0)
        # Both parts of a noise line have the variance 2 s^2 / N.
        assert one.noise == pytest.approx(0.01 * np.sqrt(4.0 / torque.size), rel=0.8)


def test_what_a_short_record_cannot_separate_shares_a_line():
    """Truth: a twentieth of a turn holds 9 turns of each wheel, and less than one beat of any two."""
    travel, torque = record(0.05, {"wheel 3": 0.05})
    found = {one.names: abs(one.amplitude) for one in named_orders(torque, travel, RATE_HZ, NAMED, MORE_ORDERS).lines}
    assert set(found) == {("wheel 2", "wheel 4", "wheel 3"), ("mesh 1",), ("mesh 2",)}
    assert found["wheel 2", "wheel 4", "wheel 3"] == pytest.approx(0.05, rel=0.25)


def test_the_residual_has_the_lines_and_other_orders_have_not():
    """Truth: the same sines; the density between the lines is that of the white noise, 2 s^2 / f_s."""
    travel, torque = record(sizes={"mesh 1": 0.02, "mesh 2": 0.03, "wheel 3": 0.02})
    (at,) = residual_emission(torque, travel, RATE_HZ, named=NAMED)
    orders = tracked_orders(NAMED)
    np.testing.assert_array_equal(at.orders, orders)
    np.testing.assert_allclose(at.amplitude[len(TRACKED) :], [0.02, 0.03, 0.0, 0.02, 0.0], atol=3e-4)
    known = np.isfinite(at.density)
    np.testing.assert_allclose(at.density[known], 2.0 * 0.01**2 / RATE_HZ, rtol=0.2)
    (without,) = residual_emission(torque, travel, RATE_HZ)
    assert without.amplitude[0] > 1.5 * at.amplitude[0], "a quarter of the step rate takes some of them"


def test_a_record_at_several_rates_has_a_line_by_its_travel():
    """Truth: one sine over the travel, whatever the rate; two rates, each in windows of its own."""
    rate = np.repeat([20.0, 40.0], 40_000)
    travel = np.cumsum(rate) / 200.0
    order = NAMED[0].order
    torque = 0.02 * np.cos(2 * np.pi * order * travel)
    found = named_orders(torque, travel, 200.0, NAMED[:1], MORE_ORDERS)
    assert len(found.lines) > 10
    np.testing.assert_allclose([abs(one.amplitude) for one in found.lines], 0.02, rtol=1e-6)
    np.testing.assert_allclose(found[1:], torque[1:], atol=2e-5)
    assert {round(one.rate) for one in found.lines} >= {20, 40}
