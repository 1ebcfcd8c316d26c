"""The criteria against their definitions on covariances that are known."""

import numpy as np
import pytest

from mechid.designs.criterion import Criterion, criterion_at, sizes
from mechid.identification.output_error.space import SearchSpace
from synthetic import truth

SIGMA = np.array([0.1, 0.5, 2.0])
SIZE = np.array([1.0, 2.0, 10.0])


@pytest.fixture
def informations():
    """Return informations of two mechanisms, (2, 3, 3): uncorrelated, and one with errors twice as large."""
    one = np.diag(SIGMA**-2.0)
    return np.array([one, one / 4.0])


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        ("D", np.log(np.prod(SIGMA / SIZE) ** (1.0 / 3.0))),
        ("A", 0.5 * np.log(np.mean((SIGMA / SIZE) ** 2))),
        ("E", np.log(np.max(SIGMA / SIZE))),
    ],
)
def test_each_kind_is_the_logarithm_of_a_standard_error(kind, expected, informations):
    """Truth: geometric mean, root mean square, largest; twice the errors add log 2, half of that on average."""
    criterion = Criterion(kind, SIZE)
    np.testing.assert_allclose(criterion.values_at(informations), [expected, expected + np.log(2.0)])
    assert criterion.of(informations) == pytest.approx(expected + 0.5 * np.log(2.0))
    low = Criterion(kind, SIZE, over="low")
    assert low.of(informations) == pytest.approx(expected + 0.8 * np.log(2.0))


def test_one_parameter_is_its_own_variance():
    """Truth: g^T M^-1 g of a random information, by numpy's inverse; batches give the same as one by one."""
    rng = np.random.default_rng(0)
    J = rng.standard_normal((2, 5, 9, 3))
    M = np.swapaxes(J, -1, -2) @ J
    g = rng.standard_normal((2, 3))
    found = Criterion("some.parameter", SIZE, g).values_at(M)
    for s in range(2):
        for c in range(5):
            assert found[s, c] == pytest.approx(0.5 * np.log(g[s] @ np.linalg.inv(M[s, c]) @ g[s]))


def test_sizes_make_errors_relative():
    """Truth: one for a logarithm, the amplitude for both parts of a detent, the value for a linear coordinate."""
    space = SearchSpace(truth())
    found = dict(zip([(c.name, c.kind) for c in space.coordinates], sizes(space, space.start[None]), strict=True))
    assert found[("gear.stiffness", "log")] == 1.0
    for kind in ("cosine", "sine"):
        assert found[("stepper.detent.1.amplitude", kind)] == pytest.approx(0.0231)
    assert found[("friction.coulomb", "linear")] == pytest.approx(0.0013)
    assert found[("friction.static", "excess")] == pytest.approx(0.0067)


def test_the_criterion_of_a_parameter_is_its_relative_error():
    """Truth: static friction is its excess plus Coulomb friction: both variances add, over the value."""
    space = SearchSpace(truth().with_free(("friction.static", "friction.coulomb")))
    criterion = criterion_at(space, space.start[None], "friction.static", "mean")
    information = np.diag([1e8, 4e8])[None]
    expected = 0.5 * np.log(1e-8 + 0.25e-8) - np.log(0.008)
    assert criterion.of(information) == pytest.approx(expected)
