"""Errors of other sources. Truth: the weights of an index at their frequencies."""

import numpy as np
import pytest

from mechid.budgets.indices import Index
from mechid.budgets.other_errors import OtherError
from mechid.errors import UsageError

APE = Index("APE")
ONE = np.array([True])


@pytest.mark.parametrize(
    ("index", "kept"), [(APE, 1.0), (Index("MPE", 50.0), 0.0), (Index("RPE", 50.0), 1.0), (Index("RPE", 0.001), 0.0)]
)
def test_slow_and_fast_noise_under_an_index(index, kept):
    """Truth: noise to 5 Hz is averaged out over 50 s and does not move within a millisecond."""
    noise = OtherError(name="n", kind="random", axes=ONE, size_rad=2.0, bandwidth_hz=5.0)
    assert noise.contribution(index, 0).size == pytest.approx(2.0 * kept, abs=0.15)


def test_an_unknown_kind_of_error_does_not_become_another():
    with pytest.raises(UsageError, match='w: unknown kind "drift"; write one of bias, random, periodic'):
        OtherError(name="w", kind="drift", axes=ONE, size_rad=2.0)


def test_a_slow_wheel_under_an_index():
    """Truth: the weight of its frequency."""
    wheel = OtherError(name="w", kind="periodic", axes=ONE, size_rad=2.0, frequency_hz=3.0)
    index = Index("RPE", 0.1)
    assert wheel.contribution(index, 0).size == pytest.approx(2.0 * np.sqrt(1.0 - np.sinc(0.3) ** 2))
    assert OtherError(name="b", kind="bias", axes=ONE, size_rad=1.0).contribution(index, 0) is None
