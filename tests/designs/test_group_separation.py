"""The records that tell rivals apart in the least time. Truth: every set of the pool."""

from itertools import combinations

import numpy as np
import pytest

from mechid.designs.group_separation import choose
from mechid.designs.separation import CLEAR, Pair


def made_up(rng, records=5, size=4, scale=1.0):
    """Return a pair of random derivatives and differences."""
    shown = tuple(scale * rng.standard_normal((size + 1, size + 1)) for _ in range(records))
    return Pair("one", "other", 0.0, 3.0 * rng.standard_normal((size + 1, size)), shown)


@pytest.mark.parametrize("seed", range(12))
def test_the_choice_tells_apart_in_little_time(seed):
    """Truth: every set of the pool. A single record is the shortest that does; a set takes at most twice the least."""
    rng = np.random.default_rng(seed)
    pairs = [made_up(rng, scale=scale) for scale in (4.0, 5.0)]
    seconds, allowed = rng.integers(10, 30, 5).astype(float), np.array([True, True, True, False, True])
    sets = [s for n in range(1, 5) for s in combinations([0, 1, 2, 4], n) if sum(seconds[list(s)]) <= 80.0]
    clear = [s for s in sets if min(p.expected_chi_square(s) for p in pairs) >= CLEAR]
    chosen = choose(pairs, allowed, seconds, 80.0)
    assert 3 not in chosen
    assert sum(seconds[list(chosen)]) <= 80.0
    assert bool(clear) == (min(p.expected_chi_square(chosen) for p in pairs) >= CLEAR)
    if clear:
        least = min(sum(seconds[list(s)]) for s in clear)
        assert sum(seconds[list(chosen)]) <= 2.0 * least
        if single := [s for s in clear if len(s) == 1]:
            assert seconds[list(chosen)].sum() == min(seconds[s[0]] for s in single)
