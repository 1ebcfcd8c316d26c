"""Offset and linear drift of a series: fitted and taken away block by block, whatever its length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechid.signal.series import IntArray, Series, blocks, counting, mean_of

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Line:
    """offset + slope k over the sample's number k, in the samples' unit."""

    offset: float = 0.0
    slope: float = 0.0

    def at(self, start: int, stop: int, step: int = 1) -> FloatArray:
        """Return its values at every `step`-th k from `start` to `stop`, (n,)."""
        return np.asarray(self.offset + self.slope * np.arange(start, stop, step), dtype=np.float64)

    def take_from(self, series: FloatArray) -> None:
        """Subtract it from a series, (n,), in place."""
        for part in blocks(series.size):
            series[part] -= self.at(part.start, part.stop)


def fit_line(series: Series, terms: int, rejected: IntArray | None = None) -> Line:
    """Return the line nearest to a series, (n,), in least squares.

    Parameters
    ----------
    series : Series
    terms : int
        0: nothing, 1: an offset, 2: offset and slope.
    rejected : (s,) of int or None
        Samples that do not count, ascending.
    """
    n = series.size
    if terms == 0 or n == 0:
        return Line()
    if rejected is not None and rejected.size:
        return _fit_line_through(series, terms, rejected)
    mean, middle = mean_of(series), 0.5 * (n - 1)
    if terms == 1 or n == 1:
        return Line(mean)
    moment = sum(float((np.arange(b.start, b.stop) - middle) @ (series[b] - mean)) for b in blocks(n))
    slope = moment * 12.0 / (n * (n**2 - 1.0))
    return Line(mean - slope * middle, slope)


def _fit_line_through(series: Series, terms: int, rejected: IntArray) -> Line:
    """Return the line nearest to those samples of a series that count."""
    n = series.size - rejected.size
    if n == 0:
        return Line()

    def both(part: slice) -> FloatArray:
        return counting(np.stack((np.arange(part.start, part.stop), series[part])), part, rejected)

    centre = sum((both(part).sum(axis=1) for part in blocks(series.size)), np.zeros(2)) / n
    spread = moment = 0.0
    for part in blocks(series.size):
        away, values = both(part) - centre[:, None]
        spread, moment = spread + float(away @ away), moment + float(away @ values)
    middle, mean = centre.tolist()
    if terms == 1 or spread == 0.0:
        return Line(mean)
    return Line(mean - moment / spread * middle, moment / spread)
