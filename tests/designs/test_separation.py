"""How clearly records tell rivals apart, against least squares by brute force and the choice against all sets."""

import numpy as np
import pytest
from scipy.optimize import minimize

from mechid.designs.separation import CLEAR, Pair, least_misfit
from mechid.identification.effects.settings import IN_DIAGNOSIS


def made_up(rng, records=5, size=4, scale=1.0):
    """Return a pair of random derivatives and differences."""
    shown = tuple(scale * rng.standard_normal((size + 1, size + 1)) for _ in range(records))
    return Pair("one", "other", 0.0, 3.0 * rng.standard_normal((size + 1, size)), shown)


def test_the_misfit_is_what_brute_force_leaves():
    """Truth: a general minimiser on the sum of squares, which knows nothing of projections."""
    rng = np.random.default_rng(1)
    pair = made_up(rng)

    def cost(x):
        known = np.sum((pair.known @ x) ** 2)
        return known + sum(np.sum((rows[:, 0] + rows[:, 1:] @ x) ** 2) for rows in pair.shown[:2])

    found = minimize(cost, np.zeros(4), method="BFGS", options={"gtol": 1e-10})
    assert least_misfit(pair.known, pair.shown[:2]) == pytest.approx(found.fun, rel=1e-9)
    assert pair.expected_chi_square([]) == 0.0


def test_what_the_parameters_can_imitate_does_not_count():
    """Truth: a difference along the derivatives is free where nothing is known, and costs where much is known."""
    rng = np.random.default_rng(2)
    J = rng.standard_normal((6, 3))
    rows = np.column_stack([J @ [1.0, -2.0, 0.5], J])
    assert least_misfit(np.zeros((1, 3)), [rows]) == pytest.approx(0.0, abs=1e-12)
    assert least_misfit(1e6 * np.eye(3), [rows]) == pytest.approx(np.sum(rows[:, 0] ** 2), rel=1e-6)


def test_clear_is_what_chance_leaves_enough_of():
    """Truth: Gaussian noise; a chi-square expected at the limit falls below what a diagnosis asks for in 2.3 %."""
    rng = np.random.default_rng(3)
    d = np.full(20, np.sqrt(CLEAR / 20.0))
    noise = rng.standard_normal((40_000, 20))
    falls = np.sum((d + noise) ** 2, axis=1) - np.sum(noise**2, axis=1)
    assert np.mean(falls < IN_DIAGNOSIS.least_chi_square) == pytest.approx(0.0228, abs=0.003)
