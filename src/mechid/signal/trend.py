"""Offset and linear drift of a series: fitted and taken away block by block, whatever its length."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BLOCK = 65536


@dataclass(frozen=True)
class Line:
    """offset + slope k over the sample's number k, in the samples' unit."""

    offset: float = 0.0
    slope: float = 0.0

    def at(self, start: int, stop: int) -> FloatArray:
        """Return its values at k from `start` to `stop`, (stop - start,)."""
        return np.asarray(self.offset + self.slope * np.arange(start, stop), dtype=np.float64)

    def take_from(self, series: FloatArray) -> None:
        """Subtract it from a series, (n,), in place."""
        for start, stop in _blocks(series.size):
            series[start:stop] -= self.at(start, stop)


def fit_line(series: FloatArray, terms: int, rejected: NDArray[np.int64] | None = None) -> Line:
    """Return the line nearest to a series, (n,), in least squares.

    Parameters
    ----------
    series : (n,)
    terms : int
        0: nothing, 1: an offset, 2: offset and slope.
    rejected : (s,) of int or None
        Samples that do not count.
    """
    n = series.size
    if terms == 0 or n == 0:
        return Line()
    if rejected is not None and rejected.size:
        return _fit_line_through(series, terms, np.delete(np.arange(n), rejected))
    mean, middle = float(series.mean()), 0.5 * (n - 1)
    if terms == 1 or n == 1:
        return Line(mean)
    moment = sum(float((np.arange(start, stop) - middle) @ (series[start:stop] - mean)) for start, stop in _blocks(n))
    slope = moment * 12.0 / (n * (n**2 - 1.0))
    return Line(mean - slope * middle, slope)


def _fit_line_through(series: FloatArray, terms: int, counted: NDArray[np.int64]) -> Line:
    """Return the line nearest to some samples of a series."""
    if not counted.size:
        return Line()
    mean, middle = float(series[counted].mean()), float(counted.mean())
    away = counted - middle
    spread = float(away @ away)
    if terms == 1 or spread == 0.0:
        return Line(mean)
    slope = float(away @ (series[counted] - mean)) / spread
    return Line(mean - slope * middle, slope)


def _blocks(samples: int) -> Iterator[tuple[int, int]]:
    for start in range(0, samples, BLOCK):
        yield start, min(start + BLOCK, samples)
