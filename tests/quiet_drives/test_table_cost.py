"""Cost of a table. Truth: differences of the cost, and the weights typed by hand."""

import numpy as np
import pytest

from mechid.command.phase_table import nominal_table
from mechid.quiet_drives.settings import QUIET
from mechid.quiet_drives.table_basis import table_harmonics
from mechid.quiet_drives.table_cost import TableCost, excess_of, peak_part
from mechid.quiet_drives.table_search import design_places


@pytest.fixture(scope="module")
def cost(mechanism):
    return TableCost(
        design_places([mechanism], nominal_table(4), [30.0], (29.0, 31.0)), (1.0, 2.0), nominal_table(4), 1.0
    )


def test_the_residuals_have_the_slopes_of_their_differences(cost):
    changes = table_harmonics(4, 5, mirrored=True)[[1, 6]]
    found = cost.simulate(cost.base, changes)
    r, J = cost.residuals(found, cost.base, changes)
    for k, change in enumerate(changes):
        moved = cost.base + 1e-5 * change
        other, _ = cost.residuals(cost.simulate(moved), moved, np.zeros((0, *moved.shape)))
        # The nominal peak stands exactly on its limit, where the excess has a kink: left out.
        inside = slice(2 * cost.base.size, None)
        wanted = (other - r)[inside] / 1e-5
        assert np.abs(J[inside, k] - wanted).max() < 5e-3 * np.abs(wanted).max()


def test_the_nominal_table_costs_its_orders_and_its_level(cost):
    """Truth: at the design rate each of two orders and the level are 1, at each place of the range nearly nothing."""
    value = cost.value(cost.simulate(cost.base), cost.base)
    far = sum(place.weight == 0.0 for place in cost.places)
    assert value == pytest.approx(3.0 + far * QUIET.pull**2, rel=1e-6)


def test_only_a_level_beyond_the_allowed_one_is_an_excess():
    assert excess_of(QUIET.allowed_rise) == (0.0, 0.0)
    assert excess_of(2.0) == pytest.approx((2.0 - QUIET.allowed_rise, 1.0))


def test_only_values_beyond_the_peak_cost():
    table = np.array([[1.0, -1.5], [0.2, 0.0]])
    excess, slope = peak_part(table, np.ones((1, 2, 2)), 1.0 / QUIET.slack)
    np.testing.assert_allclose(excess, QUIET.peak_weight * np.array([0.0, 0.5, 0.0, 0.0]), atol=1e-6)
    np.testing.assert_allclose(slope[:, 0], QUIET.peak_weight * np.array([0.0, -1.0, 0.0, 0.0]))
