"""Protocol of sample series that are read slice by slice, so that computed series are never held in memory."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mechid.arrays import FloatArray, IntArray

BLOCK = 65536
"""Number of samples processed together."""


class Series(Protocol):
    """Sequence of samples: an array, (n,), or an object that computes slices on access."""

    @property
    def size(self) -> int:
        """Number of samples n."""

    def __getitem__(self, part: slice, /) -> FloatArray:
        """Return the samples of a slice."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """View on the samples of a series from `first` to before `stop`."""

    series: Series
    first: int
    stop: int

    @property
    def size(self) -> int:
        """Number of samples."""
        return max(self.stop - self.first, 0)

    def __getitem__(self, part: slice, /) -> FloatArray:
        """Return the samples of a slice with a positive step."""
        start, stop, step = part.indices(self.size)
        return self.series[self.first + start : self.first + stop : step]


def stretch_of(series: Series, first: int, stop: int) -> Series:
    """Return a view on the samples of a series from `first` to before `stop`, limited to its length."""
    first, stop, _ = slice(first, stop).indices(series.size)
    return series[first:stop] if isinstance(series, np.ndarray) else Stretch(series, first, max(stop, first))


def blocks(samples: int, size: int = BLOCK) -> Iterator[slice]:
    """Yield the slices of consecutive blocks of at most `size` samples."""
    for start in range(0, samples, size):
        yield slice(start, min(start + size, samples))


def no_samples() -> IntArray:
    """Return an empty array of sample indices, (0,)."""
    return np.zeros(0, dtype=np.int64)


def drop_rejected(values: FloatArray, part: slice, rejected: IntArray | None) -> FloatArray:
    """Return a block of samples, (..., n), without the rejected ones; `rejected`, (s,), are ascending indices."""
    if rejected is None or not rejected.size:
        return values
    first, stop = np.searchsorted(rejected, (part.start, part.stop))
    return np.delete(values, rejected[first:stop] - part.start, axis=-1) if stop > first else values


def mean_of(series: Series, samples: int | None = None) -> float:
    """Return the mean of a series, or of its first `samples` samples."""
    n = series.size if samples is None else samples
    return sum(float(series[part].sum()) for part in blocks(n)) / n


def is_finite(series: Series) -> bool:
    """Return whether every sample is finite."""
    return all(bool(np.isfinite(series[part]).all()) for part in blocks(series.size))
