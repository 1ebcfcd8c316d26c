"""Points of a scrambled Sobol sequence."""

import numpy as np

from mechid.identification.search.box import sobol_points


def test_a_seed_gives_the_same_points_as_ever():
    """Stored fits begin there. Truth: Joe and Kuo's sequence with Matousek's scramble, written out without SciPy."""
    first = [[698390514, 984954286, 107864316], [157954000, 268807610, 670511557], [498437756, 674719580, 383116549]]
    assert np.array_equal(sobol_points(3, 4, seed=7)[:3] * 2**30, first)
