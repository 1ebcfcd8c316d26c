"""A record as a picture shows it: the extremes of each of its columns."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.signal.envelope import envelope
from mechid.signal.series import Series, blocks

COLUMNS = 800
"""Of a curve over time on paper; each holds its least and its largest sample."""


class Times(Protocol):
    """When a series was sampled."""

    @property
    def sample_rate_hz(self) -> float:
        """Samples a second."""

    @property
    def start_s(self) -> float:
        """Record time of its first sample."""


def drawn(y: Series, base: Times) -> FloatArray:
    """Return the record times in s, and samples, (2, M), that draw a record: extremes of each column of the picture."""
    kept = envelope(y, COLUMNS)
    values = np.concatenate([y[part][_within(kept, part)] for part in blocks(y.size)])
    return np.stack((base.start_s + kept / base.sample_rate_hz, values))


def _within(kept: IntArray, part: slice) -> IntArray:
    """Return those of ascending numbers that are in a block, from its first."""
    return np.asarray(kept[slice(*np.searchsorted(kept, (part.start, part.stop)))] - part.start, dtype=np.int64)
