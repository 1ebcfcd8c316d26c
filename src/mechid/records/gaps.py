"""Missing samples: found, told, and bridged by a straight line where the campaign allows it."""

from __future__ import annotations

import numpy as np

from mechid.arrays import IntArray
from mechid.signal.runs import runs_of
from mechid.signal.series import Series
from mechid.signal.stored import Room, pieces_of, samples_at, write_at


def missing_samples(series: Series) -> IntArray:
    """Return the samples that are not finite, as numbers, ascending."""
    found = [part.start + np.flatnonzero(~np.isfinite(series[part])) for part in pieces_of(series)]
    return np.concatenate([np.zeros(0, dtype=np.int64), *found])


def missing_runs(missing: IntArray) -> IntArray:
    """Return first and last-plus-one sample of each run of missing samples, shape (runs, 2)."""
    return np.array(runs_of(missing), dtype=np.int64).reshape(-1, 2)


def bridge(room: Room, missing: IntArray) -> None:
    """Replace missing samples, (M,) ascending, by the straight line between their neighbours, in place.

    At an end, where there is one neighbour only, its value is held.
    """
    runs = missing_runs(missing)
    beside = np.unique(np.concatenate((runs[:, 0] - 1, runs[:, 1])))
    beside = beside[(beside >= 0) & (beside < room.size)]
    write_at(room, missing, np.interp(missing, beside, samples_at(room, beside)))
