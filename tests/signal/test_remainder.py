"""A series less a line and a model, by slices. Truth: the same of whole arrays."""

import numpy as np
import pytest

from mechid.signal.remainder import Remainder
from mechid.signal.series import BLOCK, Stretch, drop_rejected, is_finite, mean_of
from mechid.signal.trend import Line, fit_line

RNG = np.random.default_rng(23)
N = 2 * BLOCK + 100
REJECTED = np.array([0, 3, 4, BLOCK - 1, BLOCK, BLOCK + 7, N - 1])
SERIES, MODEL = RNG.standard_normal(N) + 3.0, RNG.standard_normal(N)
LEFT = SERIES - (1.0 + 2e-6 * np.arange(N)) - MODEL
LEFT[REJECTED] = 0.0
REMAINDER = Remainder(SERIES, Line(1.0, 2e-6), MODEL, REJECTED)


@pytest.mark.parametrize(
    "part", [slice(None), slice(0, 10), slice(3, 5), slice(BLOCK - 5, BLOCK + 9), slice(1, N, 3), slice(N - 2, N + 5)]
)
def test_a_slice_is_that_of_the_array(part):
    np.testing.assert_allclose(REMAINDER[part], LEFT[part], rtol=0.0, atol=1e-14)
    np.testing.assert_array_equal(Stretch(REMAINDER, 0, BLOCK + 3)[part], REMAINDER[: BLOCK + 3][part])


def test_mean_and_finiteness_are_those_of_the_array():
    assert REMAINDER.size == N
    assert mean_of(REMAINDER) == pytest.approx(LEFT.mean(), abs=1e-14)
    assert mean_of(REMAINDER, 10) == pytest.approx(LEFT[:10].mean(), abs=1e-14)
    assert is_finite(REMAINDER)
    assert not is_finite(Remainder(SERIES, Line(np.nan)))


def test_what_counts_of_a_block_is_all_but_the_rejected():
    part = slice(BLOCK - 2, BLOCK + 10)
    kept = np.setdiff1d(np.arange(part.start, part.stop), REJECTED)
    np.testing.assert_array_equal(drop_rejected(SERIES[part], part, REJECTED), SERIES[kept])
    np.testing.assert_array_equal(drop_rejected(SERIES[part], part, None), SERIES[part])


def test_the_line_is_that_through_the_samples_that_count():
    """Truth: NumPy's polynomial fit to them."""
    kept = np.setdiff1d(np.arange(N), REJECTED)
    slope, offset = np.polyfit(kept, SERIES[kept], 1)
    line = fit_line(SERIES, 2, REJECTED)
    assert line.offset == pytest.approx(offset, rel=1e-10)
    assert line.slope == pytest.approx(slope, rel=1e-8)
    assert fit_line(SERIES, 1, REJECTED) == Line(pytest.approx(SERIES[kept].mean(), rel=1e-13))
    assert fit_line(SERIES[:1], 2, np.array([0])) == Line()
