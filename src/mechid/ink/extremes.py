"""Reduction of a record for a picture: the extremes of each column."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.signal.envelope import envelope
from mechid.signal.series import Series, blocks

COLUMNS = 800
"""Columns of a curve over time on paper; each shows its minimum and maximum."""


class Times(Protocol):
    """Sampling times of a series."""

    @property
    def sample_rate_hz(self) -> float:
        """Samples per second."""

    @property
    def start_s(self) -> float:
        """Record time of the first sample in s."""


def reduce_to_extremes(y: Series, base: Times) -> FloatArray:
    """Return times in s and samples, (2, M), of the extremes in each column of a picture."""
    kept = envelope(y, COLUMNS)
    values = np.concatenate([y[part][_within(kept, part)] for part in blocks(y.size)])
    return np.stack((base.start_s + kept / base.sample_rate_hz, values))


def _within(kept: IntArray, part: slice) -> IntArray:
    """Return the ascending indices that fall in a block, relative to its start."""
    return np.asarray(kept[slice(*np.searchsorted(kept, (part.start, part.stop)))] - part.start, dtype=np.int64)
