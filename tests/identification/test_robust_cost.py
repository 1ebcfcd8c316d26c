"""The robust cost of the multi-start; truth: soft L1 is the sum of squares where residuals are small."""

import numpy as np
import pytest

from mechid.identification.search.first_moments import robust_cost
from mechid.identification.search.settings import SEARCH
from mechid.identification.uncertainty.standard_errors import ParameterErrors, StandardErrors


@pytest.mark.parametrize("size", [1e-12, 1e-9, 1e-4])
def test_tiny_residuals_are_squared(size):
    """A mechanism at rest under the start's friction leaves next to nothing: that is no cost of exactly zero."""
    r = np.full(100, size)
    assert robust_cost(r) == pytest.approx(100 * size**2, rel=1e-8)


def test_large_residuals_count_by_their_size():
    r = np.array([1e9])
    assert robust_cost(r) == pytest.approx(2.0 * SEARCH.robust_sigmas * 1e9, rel=1e-6)


def test_a_variance_that_is_rounding_is_infinite():
    """Truth: along a direction that no record sees the variance is infinite; rounding may leave it below zero."""
    two = {"sigma": np.array([np.inf, 2.0]), "dof": np.full(2, np.inf), "correlation": np.eye(2)}
    errors = StandardErrors(names=("a", "b"), noise=np.diag([-1e9, 4.0]), white=np.eye(2), **two)
    assert errors.of("a") == ParameterErrors(held=np.inf, noise=np.inf, white=1.0)
    assert errors.of("b") == ParameterErrors(held=2.0, noise=2.0, white=1.0)
