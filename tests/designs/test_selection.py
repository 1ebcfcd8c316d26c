"""The choice of records against trying every set."""

from itertools import combinations

import numpy as np
import pytest

from mechid.designs.criterion import Criterion
from mechid.designs.selection import Pool, select


def random_pool(seed, *, records=9, total_s=10.0):
    """Return records of one to three directions each, lasting 1 to 5 s, at two mechanisms."""
    rng = np.random.default_rng(seed)
    J = rng.standard_normal((2, records, 2, 3)) * rng.uniform(0.2, 5.0, (1, records, 1, 1))
    information = np.swapaxes(J, -1, -2) @ J
    before = np.broadcast_to(1e-2 * np.eye(3), (2, 3, 3))
    return Pool(information, before, rng.uniform(1.0, 5.0, records), total_s, np.ones(records, dtype=bool))


def best_of_all(pool, criterion):
    """Return the least criterion over every set that fits."""
    n = pool.seconds.size
    sets = (s for k in range(n + 1) for s in combinations(range(n), k) if pool.seconds[list(s)].sum() <= pool.total_s)
    return min(float(criterion.of(pool.before + pool.information[:, list(s)].sum(axis=1))) for s in sets)


@pytest.mark.parametrize("kind", ["D", "A", "E"])
def test_the_choice_is_the_best_of_all_sets_or_nearly(kind):
    """Truth: enumeration of all sets of 30 pools. Mostly it is the best itself, and never a fifth of an error off."""
    criterion = Criterion(kind, np.ones(3))
    off = []
    for seed in range(30):
        pool = random_pool(seed)
        choice = select(pool, criterion)
        assert pool.seconds[list(choice.chosen)].sum() <= pool.total_s
        off.append(choice.value - best_of_all(pool, criterion))
    assert min(off) >= -1e-9
    assert max(off) <= 0.2
    assert np.mean(np.array(off) < 1e-9) >= 0.8


def test_limits_hold():
    """Truth: what is not allowed is never taken, what is kept always, nothing more often than it may."""
    pool, criterion = random_pool(3, total_s=20.0), Criterion("D", np.ones(3))
    free = select(pool, criterion)
    banned = free.chosen[0]
    allowed = np.arange(9) != banned
    barred = select(Pool(pool.information, pool.before, pool.seconds, 20.0, allowed), criterion)
    assert banned not in barred.chosen
    assert barred.value >= free.value
    worst = int(np.argmin(np.trace(pool.information[0], axis1=1, axis2=2)))
    assert worst in select(pool, criterion, [worst]).chosen
    twice = select(Pool(pool.information, pool.before, pool.seconds, 20.0, pool.allowed, 2), criterion)
    assert max(np.bincount(twice.chosen)) <= 2
    assert twice.value <= free.value + 1e-9


def test_the_trail_is_the_criterion_record_by_record():
    """Truth: the criterion of each first part; more records never tell less."""
    pool, criterion = random_pool(5), Criterion("D", np.ones(3))
    choice = select(pool, criterion)
    assert len(choice.trail) == len(choice.chosen) + 1
    assert np.all(np.diff(choice.trail) <= 1e-12)
    assert choice.trail[-1] == choice.value
