"""Minimum within limits. Truth: a quadratic whose minimum lies outside, and its closed form at the limit."""

import numpy as np
import pytest

from mechid.command.phase_table import nominal_table
from mechid.quiet_drives.linearised_cost import LinearisedCost
from mechid.quiet_drives.settings import QUIET


class OneLine:
    """A cost with the residual 2 - c and no places: its least is c = 2."""

    places = ()
    peak = 1.0
    least_fundamental = -10.0

    @staticmethod
    def design_residuals(found, table, changes):
        return np.array([2.0]), np.array([[-1.0]])


@pytest.mark.parametrize(("size", "wanted"), [(0.1, 2.0), (1.0, QUIET.slack)])
def test_the_minimum_is_found_inside_and_at_the_peak(size, wanted):
    changes = np.zeros((1, 4, 2))
    changes[0, 0, 0] = size
    step = LinearisedCost(OneLine(), (), np.zeros((4, 2)), changes).minimise(1e-9)
    assert step[0] == pytest.approx(wanted, rel=1e-3)


def test_the_fundamental_keeps_its_least_value():
    """Truth: the change takes a fundamental of 0.1 away, and 0.95 of 1 has to stay."""
    cost = OneLine()
    cost.least_fundamental = 0.95
    step = LinearisedCost(cost, (), nominal_table(4), -0.1 * nominal_table(4)[None]).minimise(1e-9)
    assert step[0] == pytest.approx(0.5, rel=1e-3)
