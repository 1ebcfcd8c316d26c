"""Rounding to codes. Truth: all codes tried one by one, and the sizes of a signed converter."""

from itertools import product

import numpy as np
import pytest

from mechid.command.phase_table import nominal_table
from mechid.quiet_drives.rounding import _nearest_codes, largest_code, plain_codes, round_table
from mechid.quiet_drives.table_basis import table_entries
from mechid.quiet_drives.table_cost import TableCost
from mechid.quiet_drives.table_search import design_places


def test_codes_are_symmetric_and_fill_the_bits():
    codes = plain_codes(nominal_table(16), 8)
    assert codes.max() == largest_code(8) == 127
    assert codes.min() == -127


def test_the_nearest_codes_cost_as_little_as_the_best_of_all():
    """Truth: the least cost of all 7^4 tables near the exact one, for a metric with one dominant direction."""
    entries = table_entries(1, mirrored=True)
    rng = np.random.default_rng(4)
    B = rng.normal(size=(3, 4))
    A, g = B.T @ B + 1e-3 * np.eye(4), np.zeros(4)
    about = np.array([[20.3, 7.4], [-3.6, 12.45], [-20.3, -7.4], [3.6, -12.45]])
    codes = _nearest_codes(about, A, g, entries, 127, 1e-9)
    np.testing.assert_array_equal(codes[2:], -codes[:2])

    def cost(values):
        move = np.asarray(values) - about[:2].ravel()
        return move @ A @ move

    around = [range(int(v) - 3, int(v) + 4) for v in np.rint(about[:2].ravel())]
    best = min(cost(values) for values in product(*around))
    plain = cost(np.rint(about[:2].ravel()))
    assert cost(codes[:2].ravel()) <= max(1.5 * best, best + 1e-12)
    assert cost(codes[:2].ravel()) < plain


@pytest.fixture(scope="module")
def cost(mechanism):
    base = nominal_table(8)
    return TableCost(design_places([mechanism], base, (30.0,), (28.0, 33.0)), (1.0, 2.0), base, 1.0)


@pytest.mark.parametrize("bits", [6, *(pytest.param(one, marks=pytest.mark.slow) for one in (8, 10))])
def test_rounding_with_the_cost_is_better_than_plain_rounding(found, cost, bits):
    """Truth: both true costs, each simulated at all rates; 0.03, 0.07, 0.17 of the plain one measured."""
    rounded = round_table(found.exact, cost, table_entries(8, mirrored=True), bits, 1.0)
    assert np.abs(rounded.codes).max() <= largest_code(bits)
    assert rounded.cost < 0.5 * rounded.plain_cost
    assert rounded.cost == pytest.approx(cost.value(cost.simulate(rounded.values), rounded.values))


def test_codes_that_keep_a_rule_are_preferred_to_plain_ones_that_break_it(found, cost):
    """Truth: the rule, here that the table is none of the plain codes, although these cost less."""
    plain = plain_codes(found.exact, 12) / largest_code(12)
    kept = round_table(
        found.exact, cost, table_entries(8, mirrored=True), 12, 1.0, lambda table: not np.allclose(table, plain)
    )
    assert not np.allclose(kept.values, plain)


def test_the_rounded_table_keeps_the_torque_reserve(found):
    """Truth: the share that the design asks for, by simulations of both tables until steps are lost."""
    assert [one.share for one in found.reserves] >= [found.design.pull_out_share]
    np.testing.assert_allclose(found.table, found.rounded.codes / 511.0)
