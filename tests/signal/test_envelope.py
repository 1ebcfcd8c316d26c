"""Truth: an envelope written out column by column, and the extremes themselves."""

import numpy as np
import pytest

from mechid.signal import peak_groups
from mechid.signal.envelope import envelope

RNG = np.random.default_rng(8)


@pytest.mark.parametrize("size", [1, 7, 40, 41, 1000, 1001, 12345])
@pytest.mark.parametrize("columns", [1, 10])
def test_each_column_keeps_its_extremes(size, columns):
    y = RNG.normal(size=size)
    kept = envelope(y, columns)
    assert np.all(np.diff(kept) > 0)
    if size <= 4 * columns:
        assert kept.tolist() == list(range(size))
        return
    assert kept.size <= 2 * columns
    for c in range(columns):
        column = range(c * size // columns, (c + 1) * size // columns)
        inside = [y[i] for i in kept if i in column]
        assert (min(inside), max(inside)) == (y[column].min(), y[column].max())


def test_a_long_curve_is_looked_at_in_parts_and_keeps_the_same_extremes():
    """Truth: NumPy's extremes of each column; 3 million samples are more than are looked at together."""
    y, columns = RNG.normal(size=3_000_001), 700
    edges = np.arange(columns) * y.size // columns
    kept = y[envelope(y, columns)]
    for ufunc in (np.minimum, np.maximum):
        assert np.isin(ufunc.reduceat(y, edges), kept).all()


@pytest.mark.parametrize("size", [2, 3, 10, 5001, 300_001])
def test_groups_of_a_spectrum_keep_every_peak_and_low_bins_alone(size):
    starts = peak_groups(size, 3000)
    assert starts[0] == 1
    assert starts.size <= 3000
    assert np.all(np.diff(starts) > 0)
    alone = starts[: np.argmax(np.diff(starts) > 1)] if np.any(np.diff(starts) > 1) else starts
    assert alone.size >= min(size - 1, 200)
    y = RNG.normal(size=size)
    assert np.maximum.reduceat(y, starts).max() == y[1:].max()
