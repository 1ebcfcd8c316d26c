"""Clipped stretches: equal samples, one after the other, at an extreme of a series."""

from __future__ import annotations

import numpy as np

from mechid.signal.moments import extremes
from mechid.signal.runs import Runs
from mechid.signal.series import Series
from mechid.signal.stored import pieces_of

CLIPPED_RUN = 8
"""So many equal samples at an extreme are a clipped peak."""


def clipped_runs(y: Series) -> Runs:
    """Return the runs of `CLIPPED_RUN` equal samples or more at the least or the largest of a series, in their order.

    Zero is rest, not a limit.

    Parameters
    ----------
    y : Series of N samples

    Examples
    --------
    >>> clipped_runs(np.array([0.5, *[2.0] * 9, 1.0, *[-2.0] * 3]))
    ((1, 10),)
    """
    limits = {*extremes(y)} - {0.0}
    return tuple(sorted(run for limit in limits for run in _runs_at(y, limit)))


def _runs_at(y: Series, limit: float) -> list[tuple[int, int]]:
    at_limit = np.zeros(y.size + 2, dtype=np.int8)
    for part in pieces_of(y):
        at_limit[part.start + 1 : part.stop + 1] = y[part] == limit
    steps = np.diff(at_limit)
    starts, ends = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    long = ends - starts >= CLIPPED_RUN
    return list(zip(starts[long].tolist(), ends[long].tolist(), strict=True))
