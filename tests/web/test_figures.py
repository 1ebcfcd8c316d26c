"""Parts of the page's figures without a browser. Truth: their definitions, on numbers by hand and at random."""

import numpy as np
import pytest
from bokeh.models import Range1d

from mechid.web.figures import TINY, hold, largest, pad_columns, round_up, spread_labels


@pytest.mark.parametrize("seed", range(10))
def test_labels_are_apart_and_none_is_lowered(seed):
    """Truth: the gap between neighbours in height; who stood lower stands lower."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(0.0, 1.0, 12).tolist()
    heights = spread_labels(places, 0.05)
    order = np.argsort(places, kind="stable")
    assert np.all(np.diff(np.array(heights)[order]) >= 0.05 - 1e-8)
    assert all(height >= place - 1e-8 for place, height in zip(places, heights, strict=True))
    assert spread_labels([0.1, 0.5], 0.05) == [0.1, 0.5]


@pytest.mark.parametrize("value", [1e-9, 0.00123, 0.5, 0.99, 1.0, 7.3, 123456.0])
def test_an_axis_ends_at_the_next_round_number(value):
    """Truth: it is no smaller, less than twice as large, and round already where it was rounded."""
    end = round_up(value)
    assert value * (1.0 - 1e-9) <= end <= 2.0 * value
    assert round_up(end) == end


def test_an_axis_is_moved_only_where_its_ends_change():
    """Truth: a zoom by hand, which stays until other ends are set."""
    axis = Range1d(start=0.0, end=1.0)
    hold(axis, 0.0, 2.0)
    axis.update(start=0.4, end=0.5)
    hold(axis, 0.0, 2.0)
    assert (axis.start, axis.end) == (0.4, 0.5)
    hold(axis, 0.0, 3.0)
    assert (axis.start, axis.end) == (0.0, 3.0)


def test_the_largest_of_curves_passes_over_what_is_not_finite():
    assert largest(np.array([1.0, np.nan, -3.0]), np.array([np.inf, 2.0])) == 3.0
    assert largest(np.array([np.nan]), np.array([])) == TINY


def test_shorter_columns_end_in_nan():
    columns = pad_columns({"a": np.arange(3.0), "b": np.arange(1.0)})
    np.testing.assert_array_equal(columns["a"], [0.0, 1.0, 2.0])
    np.testing.assert_array_equal(columns["b"], [0.0, np.nan, np.nan])
