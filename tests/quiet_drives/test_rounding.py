"""Rounding to codes. Truth: all codes tried one by one, and the sizes of a signed converter."""

from itertools import product

import numpy as np

from mechid.quiet_drives.rounding import _nearest_codes, largest_code, plain_codes
from mechid.quiet_drives.table_basis import nominal_table, table_entries


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


def test_rounding_with_the_cost_is_better_than_plain_rounding(found):
    """Truth: both true costs, each from a simulation at all rates."""
    assert found.rounded.cost < 0.7 * found.rounded.plain_cost
    assert np.abs(found.rounded.codes).max() <= largest_code(10)
    np.testing.assert_allclose(found.table, found.rounded.codes / 511.0)
