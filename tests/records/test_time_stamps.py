"""The regular clock behind late stamps. Truth: the places that the stamps were jittered from, 5 % of them lost."""

from collections import Counter

import numpy as np

from mechid.errors import RecordError
from mechid.records.time_stamps import fit_regular_clock
from stamps import Stamps

SAMPLES, RATE = 2000, 1000.0


def outcome(seed, share):
    """Return how stamps fare that are up to a share of the interval off: right, wrong or refused."""
    rng = np.random.default_rng(seed)
    kept = np.flatnonzero(rng.uniform(size=SAMPLES) >= 0.05)
    time = (kept + rng.uniform(-share, share, kept.size)) / RATE
    try:
        index = fit_regular_clock(Stamps(), time, None).places(slice(None))
    except RecordError:
        return "refused"
    return "right" if np.array_equal(index, kept - kept[0]) else "wrong"


def outcomes(share, clocks):
    return Counter(outcome(seed, share) for seed in range(clocks))


def test_stamps_up_to_four_tenths_off_are_put_right():
    assert outcomes(0.4, 200) == {"right": 200}


def test_stamps_nearly_half_an_interval_off_are_put_right_or_refused():
    found = outcomes(0.45, 50)
    assert found["wrong"] == 0
    assert min(found["right"], found["refused"]) > 0
