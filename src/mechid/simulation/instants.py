"""Sample instants of a run; those of a long record are computed on access."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.signal.series import Series
from mechid.signal.stored_series import is_long


@dataclass(frozen=True)
class Instants:
    """start_s + k / sample_rate_hz, k < size, in s."""

    start_s: float
    sample_rate_hz: float
    size: int

    def __getitem__(self, part: slice, /) -> FloatArray:
        """Return the instants of a slice."""
        numbers = np.arange(*part.indices(self.size))
        return np.asarray(self.start_s + numbers / self.sample_rate_hz, dtype=np.float64)


def instants(start_s: float, sample_rate_hz: float, samples: int) -> Series:
    """Return the sample instants of a run in s: an array, or an `Instants` if the record is long."""
    # The instants of a long record would take as much memory as its samples.
    found = Instants(start_s, sample_rate_hz, samples)
    return found if is_long(samples) else found[:]
