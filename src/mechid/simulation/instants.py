"""The sample instants of a long run, worked out where they are looked at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Instants:
    """start_s + k / sample_rate_hz, k < size, in s."""

    start_s: float
    sample_rate_hz: float
    size: int

    def __getitem__(self, part: slice, /) -> FloatArray:
        """Return those of a slice."""
        numbers = np.arange(*part.indices(self.size))
        return np.asarray(self.start_s + numbers / self.sample_rate_hz, dtype=np.float64)
