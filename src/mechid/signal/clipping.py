"""Clipped stretches: equal samples, one after the other, at an extreme of a series."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mechid.signal.runs import Runs

FloatArray = NDArray[np.float64]
CLIPPED_RUN = 8
"""So many equal samples at an extreme are a clipped peak."""


def clipped_runs(y: FloatArray) -> Runs:
    """Return the runs of `CLIPPED_RUN` equal samples or more at the least or the largest of a series, in their order.

    Zero is rest, not a limit.

    Parameters
    ----------
    y : ndarray, shape (N,)

    Examples
    --------
    >>> clipped_runs(np.array([0.5, *[2.0] * 9, 1.0, *[-2.0] * 3]))
    ((1, 10),)
    """
    limits = {float(y.min()), float(y.max())} - {0.0}
    return tuple(sorted(run for limit in limits for run in _runs_at(y, limit)))


def _runs_at(y: FloatArray, limit: float) -> list[tuple[int, int]]:
    at_limit = np.zeros(y.size + 2, dtype=np.int8)
    at_limit[1:-1] = y == limit
    steps = np.diff(at_limit)
    starts, ends = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    long = ends - starts >= CLIPPED_RUN
    return list(zip(starts[long].tolist(), ends[long].tolist(), strict=True))
