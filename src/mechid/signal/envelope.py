"""Fewer points that draw the same line: extremes of every column of a picture, peaks of a spectrum."""

from __future__ import annotations

import numpy as np

from mechid.arrays import IntArray
from mechid.signal.series import Series

MOST_AT_ONCE = 2**17
"""Samples that are looked at together, which bounds the memory that it takes."""


def envelope(y: Series, columns: int) -> IntArray:
    """Return the samples that draw a curve in so many columns: the least and the largest of each, in order.

    Parameters
    ----------
    y : Series of N samples
        In any unit.
    columns : int
        At least 1. Where a column would hold fewer than four samples, all samples are returned.

    Returns
    -------
    ndarray, shape (M,), int
        Ascending; M is at most 2 `columns`, or N.
    """
    if y.size <= 4 * columns:
        return np.arange(y.size, dtype=np.int64)
    edges = np.arange(columns + 1, dtype=np.int64) * y.size // columns
    at_once = max(MOST_AT_ONCE * columns // y.size, 1)
    both = [_extremes(y, edges[a : a + at_once + 1]) for a in range(0, columns, at_once)]
    return np.unique(np.concatenate(both, axis=1))


def _extremes(y: Series, edges: IntArray) -> IntArray:
    """Return the first least and the first largest sample of each column between edges, (2, columns)."""
    widest = int(np.diff(edges).max())
    inside = np.minimum(edges[:-1, None] + np.arange(widest), edges[1:, None] - 1)  # a short column ends twice
    values = y[slice(edges[0], edges[-1])][inside - edges[0]]
    return np.asarray(edges[:-1] + np.array([values.argmin(axis=1), values.argmax(axis=1)]), dtype=np.int64)


def peak_groups(bins: int, most: int) -> IntArray:
    """Return the first bin of groups that are equally wide on a logarithmic axis, or of one bin where those are wider.

    `numpy.maximum.reduceat` over them keeps every peak of an amplitude spectrum.

    Parameters
    ----------
    bins : int
        Equally spaced from 0.
    most : int
        Groups at most, at least 2; where there are no more bins than that, each is its own group.

    Returns
    -------
    ndarray, shape (M,), int
        Ascending, from 1: the bin at 0 belongs to no group.
    """
    last = bins - 1
    if last <= most:
        return np.arange(1, last + 1, dtype=np.int64)
    return np.unique(np.rint(np.geomspace(1.0, last, most)).astype(np.int64))
