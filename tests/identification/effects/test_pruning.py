"""What single effects explain, by the derivatives at a point. Truth: orthogonal columns, and least squares by hand."""

import numpy as np
import pytest

from mechid.identification.effects.pruning import cost_reductions, needed_groups
from mechid.identification.output_error.reduction import Triangle, triangle_of_rows


def least_squares(J, r):
    """Return the least sum of squares of r + J d."""
    return float(np.sum((r + J @ np.linalg.lstsq(J, -r, rcond=None)[0]) ** 2))


def test_groups_are_dropped_while_that_costs_less_than_their_freedom():
    """Truth: orthogonal columns, so that the rise without a group is the square of what it explains."""
    n, values = 400, np.array([5.0, 0.5, 4.0, 1.0])
    J = np.zeros((n, 4))
    J[np.arange(4), np.arange(4)] = 1.0
    rest = np.zeros(n)
    rest[10:] = 1.0
    triangle: Triangle = triangle_of_rows(rest, J)
    groups = {"clear": (0,), "chance": (1,), "both": (2, 3)}
    found = needed_groups(triangle, values, groups, effective_samples=float(n))
    assert found == pytest.approx({"clear": 25.0, "both": 17.0})


def test_of_two_groups_that_do_the_same_one_is_kept():
    """Truth: equal columns: without one of them the other makes up for it; without both the cost rises by 100."""
    J = np.zeros((50, 2))
    J[3] = 1.0
    found = needed_groups(triangle_of_rows(np.zeros(50), J), np.array([10.0, 0.0]), {"one": (0,), "same": (1,)}, 50.0)
    assert len(found) == 1
    assert next(iter(found.values())) == pytest.approx(100.0)


def test_a_fall_is_what_one_group_explains_beside_what_is_in_none():
    """Truth: least squares by hand over random rows. The first two columns are of the mechanism, which makes room."""
    rng = np.random.default_rng(3)
    J, r = rng.standard_normal((60, 6)), rng.standard_normal(60)
    r -= 2.0 * J[:, 3] + 0.5 * J[:, 1]
    groups = {"right": (3,), "wrong": (2,), "two": (4, 5)}
    found = cost_reductions(triangle_of_rows(r, J), groups)
    plain = least_squares(J[:, :2], r)
    for name, places in groups.items():
        assert found[name] == pytest.approx(plain - least_squares(J[:, [0, 1, *places]], r), rel=1e-8), name
    assert found["right"] > 10.0 * max(found["wrong"], found["two"])


def test_a_prior_makes_an_effect_explain_less():
    """Truth: one column of 1 with a residual of 3 and a prior of width 1/2: 9 of misfit, 9/5 with it."""
    rows = np.array([[1.0], [2.0]])
    assert cost_reductions(triangle_of_rows(np.array([-3.0, 0.0]), rows), {"small": (0,)})["small"] == pytest.approx(
        9.0 / 5.0
    )
