"""Runs of consecutive sample indices: pairs of first index and last index plus one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mechid.arrays import IntArray

Runs = tuple[tuple[int, int], ...]


def runs_of(samples: IntArray) -> Runs:
    """Return the runs of sample indices, (n,) ascending.

    Examples
    --------
    >>> runs_of(np.array([3, 4, 5, 9]))
    ((3, 6), (9, 10))
    """
    breaks = np.flatnonzero(np.diff(samples) != 1) + 1
    return tuple((int(run[0]), int(run[-1]) + 1) for run in np.split(samples, breaks) if run.size)


def samples_of(runs: Sequence[Sequence[int]]) -> IntArray:
    """Return the sample indices of runs, (n,) ascending.

    Examples
    --------
    >>> samples_of([(3, 6), (9, 10)])
    array([3, 4, 5, 9])
    """
    return np.concatenate([np.arange(0), *(np.arange(first, stop) for first, stop in runs)]).astype(np.int64)
