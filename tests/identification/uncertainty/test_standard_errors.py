"""Standard errors in the file's coordinates, from covariances that are known. Truth: by hand."""

import numpy as np
import pytest

from mechid.identification.uncertainty import model_error
from mechid.identification.uncertainty.model_error import ModelError
from mechid.identification.uncertainty.standard_errors import ParameterErrors, StandardErrors, _Spread


def test_a_variance_that_is_rounding_is_infinite():
    """Truth: along a direction that no record sees the variance is infinite; rounding may leave it below zero."""
    two = {"sigma": np.array([np.inf, 2.0]), "dof": np.full(2, np.inf), "correlation": np.eye(2)}
    errors = StandardErrors(names=("a", "b"), noise=np.diag([-1e9, 4.0]), white=np.eye(2), **two)
    assert errors.errors_of("a") == ParameterErrors(total=np.inf, noise=np.inf, white=1.0)
    assert errors.errors_of("b") == ParameterErrors(total=2.0, noise=2.0, white=1.0)


def test_half_of_what_is_beyond_noise_is_correlated():
    """Truth: by hand; noise of 1 and 0.5, an excess all but wholly correlated, half of whose covariance stays."""
    noise, excess = np.array([[1.0, 0.5], [0.5, 1.0]]), np.array([[10.0, 9.5], [9.5, 10.0]])
    spread = _Spread(np.eye(2))
    spread.add(ModelError(noise, (model_error.Excess(excess, 8.0),)))
    sigma, dof, correlation = spread.totals(np.zeros((2, 2)))
    beyond = ModelError(noise, (model_error.Excess(excess, 8.0),)).matrix - noise
    assert sigma == pytest.approx(np.sqrt([10.0, 10.0]))
    assert dof == pytest.approx([100.0 / (81.0 / 8.0)] * 2)
    assert correlation[0, 1] == pytest.approx((0.5 + 0.5 * beyond[0, 1]) / (1.0 + beyond[0, 0]))
    alone = _Spread(np.eye(2))
    alone.add(ModelError(noise))
    assert alone.totals(np.zeros((2, 2)))[2] == pytest.approx(noise)


def test_errors_without_a_parameter_are_those_of_the_others():
    """Truth: the rows and columns of the others, which stay as uncertain as they were."""
    correlation = np.array([[1.0, 0.2, 0.3], [0.2, 1.0, 0.4], [0.3, 0.4, 1.0]])
    every = StandardErrors(
        names=("a", "b", "c"),
        sigma=np.array([1.0, 2.0, 3.0]),
        dof=np.array([np.inf, 8.0, np.inf]),
        correlation=correlation,
        noise=np.diag([1.0, 4.0, 9.0]),
        white=np.eye(3),
    )
    kept = every.drop(("b",))
    assert kept.names == ("a", "c")
    assert kept.covariance == pytest.approx(np.array([[1.0, 0.9], [0.9, 9.0]]))
    assert kept.errors_of("c") == every.errors_of("c") == ParameterErrors(total=3.0, noise=3.0, white=1.0)
    assert kept.errors_of("b") == ParameterErrors()
    assert kept.error_without_priors("a") is None
