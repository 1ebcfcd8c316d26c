"""Reduction of curves for plotting: extremes per pixel column, and groups of spectral bins."""

from __future__ import annotations

import numpy as np

from mechid.arrays import IntArray
from mechid.signal.series import Series

BLOCK_SAMPLES = 2**17
"""Number of samples processed together, which bounds the memory."""


def envelope(y: Series, columns: int) -> IntArray:
    """Return the indices of the minimum and the maximum of each column of a plotted curve.

    Parameters
    ----------
    y : Series of N samples
        In any unit.
    columns : int
        At least 1. If there are at most four samples per column, all samples are returned.

    Returns
    -------
    ndarray, shape (M,), int
        Ascending; M is at most 2 `columns`, or N.
    """
    if y.size <= 4 * columns:
        return np.arange(y.size, dtype=np.int64)
    edges = np.arange(columns + 1, dtype=np.int64) * y.size // columns
    at_once = max(BLOCK_SAMPLES * columns // y.size, 1)
    both = [_extremes(y, edges[a : a + at_once + 1]) for a in range(0, columns, at_once)]
    return np.unique(np.concatenate(both, axis=1))


def _extremes(y: Series, edges: IntArray) -> IntArray:
    """Return the indices of the first minimum and the first maximum between adjacent edges, (2, columns)."""
    widest = int(np.diff(edges).max())
    # Column widths differ by at most one sample; shorter columns repeat their last sample, which changes no extreme.
    inside = np.minimum(edges[:-1, None] + np.arange(widest), edges[1:, None] - 1)
    values = y[slice(edges[0], edges[-1])][inside - edges[0]]
    return np.asarray(edges[:-1] + np.array([values.argmin(axis=1), values.argmax(axis=1)]), dtype=np.int64)


def peak_groups(bins: int, most: int) -> IntArray:
    """Return the first bins of groups of equal width on a logarithmic axis; no group is narrower than a bin.

    `numpy.maximum.reduceat` with these groups keeps every peak of an amplitude spectrum.

    Parameters
    ----------
    bins : int
        Number of bins, equally spaced from 0.
    most : int
        Maximum number of groups, at least 2. If there are no more bins than this, each bin is a group.

    Returns
    -------
    ndarray, shape (M,), int
        Ascending, from 1: the bin at 0 belongs to no group.
    """
    last = bins - 1
    if last <= most:
        return np.arange(1, last + 1, dtype=np.int64)
    return np.unique(np.rint(np.geomspace(1.0, last, most)).astype(np.int64))
