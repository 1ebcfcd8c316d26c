"""Points of a scrambled Sobol sequence."""

import numpy as np
import pytest
from scipy.stats import qmc

from mechid.identification.search.box import DIRECTIONS, sobol_points


@pytest.mark.parametrize("seed", [0, 7])
@pytest.mark.parametrize("dimensions", [1, 2, 16, len(DIRECTIONS), len(DIRECTIONS) + 1])
@pytest.mark.parametrize("points", [1, 2, 2048])
def test_they_are_those_of_scipy(dimensions, points, seed):
    """To the last bit: where a search begins is part of what a seed promises."""
    truth = qmc.Sobol(dimensions, scramble=True, rng=np.random.default_rng(seed)).random(points)
    assert np.array_equal(sobol_points(dimensions, points, seed), truth)
