"""Minimum within limits. Truth: a quadratic whose minimum lies outside, and its closed form at the limit."""

import numpy as np
import pytest

from mechid.quiet_drives.linearised_cost import LinearisedCost
from mechid.quiet_drives.settings import QUIET


class OneLine:
    """A cost with the residual 2 - c and no places: its least is c = 2."""

    places = ()
    peak = 1.0

    @staticmethod
    def design_residuals(found, table, changes):
        return np.array([2.0]), np.array([[-1.0]])


@pytest.mark.parametrize(("size", "wanted"), [(0.1, 2.0), (1.0, QUIET.slack)])
def test_the_minimum_is_found_inside_and_at_the_peak(size, wanted):
    changes = size * np.ones((1, 1, 1))
    step = LinearisedCost(OneLine(), (), np.zeros((1, 1)), changes).minimise(1e-9)
    assert step[0] == pytest.approx(wanted, rel=1e-3)
