"""Truth: the integral of |rate| by fine summation, and the step edges themselves."""

import numpy as np
import pytest

from mechid.command import Command, RateProfile
from mechid.command.edges import steps_travelled

PROFILES = {
    "constant": RateProfile.constant(46.0),
    "backwards": RateProfile.constant(-46.0),
    "sweep": RateProfile.through([(0.0, 0.0), (2.0, 120.0)]),
    "reversal": RateProfile.through([(0.0, 30.0), (0.5, 30.0), (1.0, -50.0), (1.2, -50.0)]),
    "jump": RateProfile.through([(0.2, 10.0), (0.7, 10.0), (0.7, -25.0), (1.1, 0.0)]),
    "begun before zero": RateProfile.through([(-1.0, 0.0), (1.0, 40.0)]),
}


@pytest.mark.parametrize("name", PROFILES)
def test_it_is_the_integral_of_the_speed(name):
    profile, fine = PROFILES[name], np.linspace(0.0, 2.0, 2_000_001)
    rates = np.interp(fine, profile.times_s, profile.rates)
    summed = np.concatenate([[0.0], np.cumsum(0.5 * np.abs(rates[1:] + rates[:-1]) * np.diff(fine))])
    times = np.array([-0.5, 0.0, 0.3, 0.69, 0.95, 1.15, 2.0])
    np.testing.assert_allclose(steps_travelled(profile, times), np.interp(times, fine, summed), atol=1e-4, err_msg=name)


def test_at_each_edge_another_step_is_done():
    command = Command(stepping="micro", microsteps=16, rate=PROFILES["sweep"])
    edges = command.excitation(3.0).times
    np.testing.assert_allclose(16.0 * steps_travelled(command.rate, edges), 1.0 + np.arange(edges.size), atol=1e-6)


def test_nothing_is_travelled_before_zero():
    np.testing.assert_array_equal(steps_travelled(PROFILES["constant"], np.array([-2.0, -1.0])), 0.0)
