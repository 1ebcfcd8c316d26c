"""Detection of clipping: runs of equal samples at an extreme of a series."""

from __future__ import annotations

import numpy as np

from mechid.arrays import FloatArray
from mechid.signal.moments import extremes
from mechid.signal.runs import Runs
from mechid.signal.series import Series
from mechid.signal.stored_series import pieces_of

CLIPPED_RUN = 8
"""Least number of consecutive equal samples at an extreme that counts as clipping."""


def clipped_runs(y: Series) -> Runs:
    """Return the runs of at least `CLIPPED_RUN` samples equal to the minimum or the maximum of a series, in order.

    An extreme of zero is not a limit: it is the value at rest.

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
    found: list[tuple[int, int]] = []
    for part in pieces_of(y):
        for start, stop in _runs_within(y[part], limit):
            first = part.start + start
            # The run continues from the previous piece.
            if found and found[-1][1] == first:
                first = found.pop()[0]
            found.append((first, part.start + stop))
    return [(start, stop) for start, stop in found if stop - start >= CLIPPED_RUN]


def _runs_within(y: FloatArray, limit: float) -> list[tuple[int, int]]:
    """Return the runs in a piece of a series that are long enough or touch its ends."""
    # A sample below the limit is added at both ends, so that runs at the ends have a start and a stop too.
    at_limit = np.zeros(y.size + 2, dtype=np.int8)
    at_limit[1:-1] = y == limit
    steps = np.diff(at_limit)
    starts, ends = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    kept = (ends - starts >= CLIPPED_RUN) | (starts == 0) | (ends == y.size)
    return list(zip(starts[kept].tolist(), ends[kept].tolist(), strict=True))
