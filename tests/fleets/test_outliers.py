"""Units that stand off. Truth: Rosner's published example, the slow way, and rates over seeded draws."""

import numpy as np
import pytest

from mechid.fleets.fleet import fleet_outliers
from mechid.fleets.outliers import deleted_residuals, farthest
from mechid.fleets.regression import random_effects_mean

ROSNER = np.fromstring(
    """
    -0.25 0.68 0.94 1.15 1.20 1.26 1.26 1.34 1.38 1.43 1.49 1.49 1.55 1.56 1.58 1.65 1.69 1.70 1.76 1.77 1.81 1.91 1.94
    1.96 1.99 2.06 2.09 2.10 2.14 2.15 2.23 2.24 2.26 2.35 2.37 2.40 2.47 2.54 2.62 2.64 2.90 2.92 2.92 2.93 3.21 3.26
    3.30 3.59 3.68 4.30 4.64 5.34 5.42 6.01
    """,
    sep=" ",
)
PARAMETERS = 15


def named_in_a_fleet(rng, n, moved=0, off=0.0):
    """Return who is named of 15 parameters of n units, the first of them with some units moved by so many spreads."""
    errors = 2.0 ** rng.uniform(-1.0, 1.0, (PARAMETERS, n))
    values = 4.0 * rng.standard_normal((PARAMETERS, n)) + errors * rng.standard_normal((PARAMETERS, n))
    values[0, :moved] += 4.0 * off
    return fleet_outliers({str(k): farthest(v, e) for k, (v, e) in enumerate(zip(values, errors, strict=True))}, 0.05)


def test_rosners_example_has_three_outliers_of_which_the_first_two_hide_behind_the_third():
    """Rosner 1983 and the NIST handbook: at 5 % 6.01, 5.42 and 5.34; neither one nor two alone are significant."""
    found = farthest(ROSNER, np.full(ROSNER.size, 1e-6))
    assert ROSNER[[one.unit for one in found]].tolist() == [6.01, 5.42, 5.34]
    assert all(one.p_value < 0.05 for one in found)
    assert found[0].p_value == found[2].p_value


@pytest.mark.parametrize("spread_of_units", [0.0, 1.0, 1e4])
@pytest.mark.parametrize("n", [3, 7, 20])
def test_all_residuals_at_once_are_those_one_by_one(n, spread_of_units):
    rng = np.random.default_rng(n)
    errors = 2.0 ** rng.uniform(-1.0, 1.0, n)
    values = spread_of_units * rng.standard_normal(n) + errors * rng.standard_normal(n)
    slow = []
    for k in range(n):
        others = np.delete(np.arange(n), k)
        mean = random_effects_mean(values[others], errors[others])
        error = np.sqrt(errors[k] ** 2 + mean.scatter**2 + mean.error() ** 2)
        slow.append((values[k] - mean.coefficients[0]) / error)
    assert deleted_residuals(values, errors) == pytest.approx(slow, rel=1e-9)


def test_three_units_have_none():
    assert farthest(np.array([1.0, 1.0, 9.0]), np.full(3, 0.1)) == ()


@pytest.mark.parametrize("n", [10, 20])
def test_fleets_without_any_have_one_no_more_often_than_the_rate(n):
    """Of 200 fleets 5 % are 10, with a standard error of 3."""
    rng = np.random.default_rng(n)
    assert sum(any(named_in_a_fleet(rng, n).values()) for _ in range(200)) <= 19


@pytest.mark.parametrize("moved", [1, 2])
def test_units_ten_spreads_off_are_found_also_two_on_one_side(moved):
    rng = np.random.default_rng(7)
    found = [named_in_a_fleet(rng, 20, moved, 10.0).get("0", ()) for _ in range(30)]
    assert sum(set(range(moved)) <= {one.unit for one in each} for each in found) >= 27
