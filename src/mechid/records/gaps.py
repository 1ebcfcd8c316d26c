"""Missing samples: found, told, and bridged by a straight line where the campaign allows it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mechid.records.table import FloatArray


def missing_runs(data: FloatArray) -> NDArray[np.int64]:
    """Return first and last-plus-one sample of each run of samples that are not finite, shape (runs, 2)."""
    bad = np.zeros(data.size + 2, dtype=np.int8)
    bad[1:-1] = ~np.isfinite(data)
    steps = np.diff(bad)
    return np.stack((np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)), axis=1)


def bridge(data: FloatArray) -> None:
    """Replace samples of shape (N,) that are not finite by the straight line between their neighbours, in place.

    At an end, where there is one neighbour only, its value is held.
    """
    good = np.isfinite(data)
    places = np.flatnonzero(~good)
    data[places] = np.interp(places, np.flatnonzero(good), data[good])
