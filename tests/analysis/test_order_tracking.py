"""Truth: torques put together from sines of the commanded position, and a model that is off by a known share."""

import math

import numpy as np
import pytest

from mechid.analysis.order_tracking import ORDERS, order_errors, order_lines
from mechid.command import RateProfile
from mechid.command.edges import steps_travelled

RATE_HZ = 10_000.0
SWEEP = RateProfile.through([(0.0, 10.0), (4.0, 90.0)])


def lines(travel, amplitudes, phase_deg=0.0):
    """Return sines of equal phase at `ORDERS`."""
    return sum(
        a * np.cos(2.0 * np.pi * o * travel + math.radians(phase_deg)) for o, a in zip(ORDERS, amplitudes, strict=True)
    )


@pytest.fixture(params=[RateProfile.constant(46.0), SWEEP, RateProfile.constant(-23.0)], ids=["46", "sweep", "back"])
def travel(request):
    return steps_travelled(request.param, np.arange(40_001) / RATE_HZ)


def test_a_model_off_by_a_share_and_an_angle(travel):
    """2 % more amplitude and 5 deg ahead, at every order, whatever the rate."""
    amplitudes = [0.1, 0.7, 0.05, 0.02, 0.01]
    noise = 1e-3 * np.random.default_rng(2).standard_normal(travel.size)
    found = order_errors(
        lines(travel, amplitudes) + noise, lines(travel, [1.02 * a for a in amplitudes], 5.0), travel, RATE_HZ
    )
    assert [e.order for e in found] == list(ORDERS)
    for error, amplitude in zip(found, amplitudes, strict=True):
        own = 3.0 * 1e-3 * math.sqrt(2.0 / travel.size) / amplitude
        assert error.measured == pytest.approx(amplitude, rel=4.0 * own)
        assert error.amplitude_error_percent == pytest.approx(2.0, abs=400.0 * own)
        assert error.phase_error_deg == pytest.approx(5.0, abs=4.0 * math.degrees(own))


def test_a_line_in_the_noise_has_no_error(travel):
    noise = 0.1 * np.random.default_rng(3).standard_normal(travel.size)
    found = order_errors(lines(travel, [0.5, 0.0, 0.0, 0.0, 0.0]) + noise, 0.0 * travel, travel, RATE_HZ)
    assert [e.amplitude_error_percent is None for e in found] == [False, True, True, True, True]


def test_the_peak_of_a_sweep_is_told_with_its_rate():
    """A resonance at 46 Hz under order 1 has its largest amplitude in the window that passes 46 steps/s."""
    time = np.arange(40_001) / RATE_HZ
    travel, rate = steps_travelled(SWEEP, time), 10.0 + 20.0 * time
    resonance = 1.0 / np.sqrt((1.0 - (rate / 46.0) ** 2) ** 2 + (0.1 * rate / 46.0) ** 2)
    y = resonance * np.cos(2.0 * np.pi * travel)
    first = next(e for e in order_errors(y, y, travel, RATE_HZ) if e.order == 1.0)
    assert first.windows == int(travel[-1] / 16.0)
    assert first.peak_rate == pytest.approx(46.0, abs=4.0)
    assert first.peak_modelled == pytest.approx(first.peak_measured)
    assert first.phase_error_deg == pytest.approx(0.0, abs=1e-9)


def test_a_dwell_belongs_to_no_window():
    """A command that rests in its middle gives what the same command without the rest gives."""
    rests = RateProfile.through([(0.0, 40.0), (1.0, 40.0), (1.0, 0.0), (2.0, 0.0), (2.0, 40.0)])
    travel = steps_travelled(rests, np.arange(30_001) / RATE_HZ)
    y = lines(travel, [0.0, 0.3, 0.0, 0.0, 0.0]) + np.where(np.diff(travel, prepend=0.0) > 0.0, 0.0, 9.0)
    first = next(e for e in order_errors(y, y, travel, RATE_HZ) if e.order == 1.0)
    assert first.measured == pytest.approx(0.3, rel=1e-6)
    assert first.peak_rate == pytest.approx(40.0, rel=1e-3)


def test_orders_end_below_half_the_sample_rate():
    travel = steps_travelled(RateProfile.constant(110.0), np.arange(2001) / 500.0)
    assert [e.order for e in order_errors(np.cos(travel), np.cos(travel), travel, 500.0)] == [0.5, 1.0]


def test_too_short_a_way_has_no_orders():
    travel = steps_travelled(RateProfile.constant(3.0), np.arange(10_001) / RATE_HZ)
    assert order_errors(np.cos(travel), np.cos(travel), travel, RATE_HZ) == ()


def test_lines_of_signals_side_by_side_with_their_windows(travel):
    """Truth: two sines of the position, the second of twice the amplitude and a quarter turn ahead."""
    y, z = 0.3 * np.cos(2.0 * np.pi * travel), -0.6 * np.sin(2.0 * np.pi * travel)
    lines_of_one = list(order_lines((y, z), travel, RATE_HZ, (1.0, 16.0)))
    assert {line.order for line in lines_of_one} == {1.0, 16.0}
    for line in (line for line in lines_of_one if line.order == 1.0):
        assert line.amplitudes == pytest.approx((0.3, 0.6j), abs=1e-9)
        first, stop = line.samples
        covered = abs(travel[stop - 1] - travel[first]) * RATE_HZ / (stop - first - 1)
        assert line.rate == pytest.approx(covered)


def test_power_less_noise_scatters_about_nothing(travel):
    """Truth: of white noise alone the squared amplitude less twice the squared error is zero on average."""
    noise = np.random.default_rng(4).standard_normal((8, travel.size))
    found = list(order_lines(noise, travel, RATE_HZ, (1.0, 2.0)))
    powers = np.array([[line.power(k) for k in range(8)] for line in found])
    usual = np.mean([2.0 * line.errors[0] ** 2 for line in found])
    assert abs(powers.mean()) < 4.0 * usual / np.sqrt(powers.size)
