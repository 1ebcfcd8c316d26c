"""Offset, linear drift and sines of a series, fitted and subtracted block by block for any length."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.signal.series import Series, blocks, drop_rejected, mean_of, no_samples
from mechid.signal.stored_series import WritableSeries

RANK_TOLERANCE = 1e-10
"""Relative cut-off of the singular values of the normal equations of offset, drift and waves."""


@dataclass(frozen=True)
class Wave:
    """Wave cosine * cos(2 pi turns k) + sine * sin(2 pi turns k) over the sample index k, in the samples' unit."""

    turns: float
    cosine: float
    sine: float


@dataclass(frozen=True)
class Line:
    """Line offset + slope k over the sample index k, plus waves, in the samples' unit."""

    offset: float = 0.0
    slope: float = 0.0
    waves: tuple[Wave, ...] = ()

    def at(self, start: int, stop: int, step: int = 1) -> FloatArray:
        """Return the values at every `step`-th k from `start` to before `stop`, (n,)."""
        k = np.arange(start, stop, step)
        values = np.asarray(self.offset + self.slope * k, dtype=np.float64)
        for wave, (cosine, sine) in zip(self.waves, waves_at(self.turns, k), strict=True):
            values += wave.cosine * cosine + wave.sine * sine
        return values

    @property
    def turns(self) -> tuple[float, ...]:
        """Frequencies of the waves in turns per sample."""
        return tuple(wave.turns for wave in self.waves)

    def __neg__(self) -> Line:
        return Line(-self.offset, -self.slope, tuple(Wave(w.turns, -w.cosine, -w.sine) for w in self.waves))

    def subtract_from(self, series: WritableSeries) -> None:
        """Subtract the line from a series in place."""
        for part in blocks(series.size):
            series[part] = series[part] - self.at(part.start, part.stop)


def waves_at(turns: Sequence[float], k: IntArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield cosine and sine, (n,) each, of waves with given turns per sample at sample indices k."""
    for each in turns:
        # Whole turns are removed first: the sine of a large argument would lose digits.
        angle = 2.0 * np.pi * ((each * k) % 1.0)
        yield np.cos(angle), np.sin(angle)


def fit_line(series: Series, terms: int, rejected: IntArray | None = None, turns: Sequence[float] = ()) -> Line:
    """Fit a line to a series, (n,), by least squares.

    Parameters
    ----------
    series : Series
    terms : int
        0: no terms, 1: offset, 2: offset and slope.
    rejected : (s,) of int or None
        Indices of samples to exclude, ascending.
    turns : sequence of float
        Frequencies of additional waves in turns per sample.
    """
    n = series.size
    if turns and n:
        return _fit_with_waves(series, terms, no_samples() if rejected is None else rejected, turns)
    if terms == 0 or n == 0:
        return Line()
    if rejected is not None and rejected.size:
        return _fit_accepted_samples(series, terms, rejected)
    # About the middle of the series offset and slope are orthogonal, so each follows from one sum.
    mean, middle = mean_of(series), 0.5 * (n - 1)
    if terms == 1 or n == 1:
        return Line(mean)
    moment = sum(float((np.arange(b.start, b.stop) - middle) @ (series[b] - mean)) for b in blocks(n))
    slope = moment * 12.0 / (n * (n**2 - 1.0))
    return Line(mean - slope * middle, slope)


def _fit_accepted_samples(series: Series, terms: int, rejected: IntArray) -> Line:
    """Fit a line to the accepted samples of a series."""
    n = series.size - rejected.size
    if n == 0:
        return Line()

    def both(part: slice) -> FloatArray:
        return drop_rejected(np.stack((np.arange(part.start, part.stop), series[part])), part, rejected)

    centre = sum((both(part).sum(axis=1) for part in blocks(series.size)), np.zeros(2)) / n
    spread = moment = 0.0
    for part in blocks(series.size):
        away, values = both(part) - centre[:, None]
        spread, moment = spread + float(away @ away), moment + float(away @ values)
    middle, mean = centre.tolist()
    if terms == 1 or spread == 0.0:
        return Line(mean)
    return Line(mean - moment / spread * middle, moment / spread)


def _fit_with_waves(series: Series, terms: int, rejected: IntArray, turns: Sequence[float]) -> Line:
    """Fit a line with waves by normal equations; terms that a short series cannot resolve get the minimum norm."""
    # The index is centred and scaled to [-1, 1], which keeps the normal equations well conditioned.
    middle, half = 0.5 * (series.size - 1), max(0.5 * series.size, 1.0)
    products = np.zeros((terms + 2 * len(turns) + 1,) * 2)
    for part in blocks(series.size):
        k = np.arange(part.start, part.stop)
        powers = [np.ones(k.size), (k - middle) / half][:terms]
        columns = np.stack([*powers, *(one for pair in waves_at(turns, k) for one in pair), series[part]])
        columns = drop_rejected(columns, part, rejected)
        products += columns @ columns.T
    found = np.linalg.lstsq(products[:-1, :-1], products[:-1, -1], rcond=RANK_TOLERANCE)[0]
    slope = float(found[1]) / half if terms > 1 else 0.0
    offset = float(found[0]) - slope * middle if terms else 0.0
    pairs = found[terms:].reshape(-1, 2).tolist()
    return Line(offset, slope, tuple(Wave(t, a, b) for t, (a, b) in zip(turns, pairs, strict=True)))
