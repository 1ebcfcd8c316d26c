"""A linear model with names and errors. Truth: a spring, a mass and a damper in closed form, and differences of it."""

import json

import numpy as np
import pytest

from mechid.exports.linear.state_space import LinearModel, Matrices, Signals, Uncertain

STIFFNESS, DAMPING = 400.0, 0.8
COVARIANCE = np.array([[25.0, 0.03], [0.03, 1e-4]])
FREQUENCY_HZ = np.array([0.5, 3.1, 3.2, 20.0])


def matrices(stiffness, damping):
    """Return x'' = F - k x - c x' with x as its output, of 1 kg."""
    A = np.array([[0.0, 1.0], [-stiffness, -damping]])
    return Matrices(A, np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]]), np.zeros((1, 1)))


def by_parameter():
    """Return the derivatives of the matrices to stiffness and damping, by hand."""
    slopes = np.zeros((2, 2, 2))
    slopes[0, 1, 0] = slopes[1, 1, 1] = -1.0
    return Matrices(slopes, np.zeros((2, 2, 1)), np.zeros((2, 1, 2)), np.zeros((2, 1, 1)))


@pytest.fixture
def model():
    here = matrices(STIFFNESS, DAMPING)
    return LinearModel(
        name="holding",
        states=Signals(("x", "v"), ("m", "m/s")),
        inputs=Signals(("F",), ("N",)),
        outputs=Signals(("x",), ("m",)),
        matrices=here,
        x=np.zeros(2),
        y=np.zeros(1),
        names=("stiffness", "damping"),
        by_parameter=by_parameter(),
        uncertain=Uncertain(
            ("damping", "stiffness"), ("N*s/m", "N/m"), np.array([DAMPING, STIFFNESS]), COVARIANCE[::-1, ::-1]
        ),
        limits={"F": (-1.0, 1.0)},
        margins={},
        samples=Matrices(*(matrix[None] for matrix in here.all)),
        draws=np.array([[DAMPING, STIFFNESS]]),
    )


def closed_form(stiffness, damping):
    w = 2.0 * np.pi * FREQUENCY_HZ
    return 1.0 / (stiffness - w**2 + 1j * damping * w)


def test_the_response_is_the_closed_form(model):
    """Truth: 1/(k - w^2 + i c w)."""
    here = model.response(FREQUENCY_HZ)[:, 0, 0]
    np.testing.assert_allclose(here, closed_form(STIFFNESS, DAMPING), rtol=1e-12)


def test_the_error_of_an_amplitude_is_that_of_its_differences(model):
    """Truth: central differences of the closed form through the covariance, which stands in another order."""
    steps = (1e-3, 1e-6)
    slopes = np.array(
        [
            (np.abs(closed_form(STIFFNESS + a, DAMPING + b)) - np.abs(closed_form(STIFFNESS - a, DAMPING - b)))
            / (2.0 * step)
            for step, a, b in ((steps[0], steps[0], 0.0), (steps[1], 0.0, steps[1]))
        ]
    )
    expected = np.sqrt(np.einsum("if,ij,jf->f", slopes, COVARIANCE, slopes))
    np.testing.assert_allclose(model.amplitude_sigma(FREQUENCY_HZ)[:, 0, 0], expected, rtol=1e-6)
    np.testing.assert_allclose(model.uncertain.std_errors, [0.01, 5.0])


def test_the_dict_is_plain_and_holds_the_matrices(model):
    """Truth: the matrices, read back from JSON."""
    data = json.loads(json.dumps(model.to_dict()))
    np.testing.assert_array_equal(data["A"], model.matrices.A)
    np.testing.assert_array_equal(data["by_parameter"]["A"], model.by_parameter.A)
    assert data["states"] == {"names": ["x", "v"], "units": ["m", "m/s"]}
    joined = model.matrices.block_matrix
    assert joined.shape == (3, 3)
    np.testing.assert_array_equal(joined[:2, :2], model.matrices.A)
    np.testing.assert_array_equal(joined[2:, :2], model.matrices.C)
