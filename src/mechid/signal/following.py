"""Test of a model against a measured series, stretch by stretch."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.signal.series import Series
from mechid.signal.settings import SERIES


@dataclass(frozen=True, kw_only=True)
class Following:
    """How far a model follows a series.

    Attributes
    ----------
    lost : int or None
        First sample of the first window that is not followed; None where all are.
    share : float
        Of the samples, those in windows that are followed.
    worst : float
        Largest ratio of a window's residual RMS to what is allowed there; infinite where a simulation failed.
    worst_at : int
        First sample of that window.
    """

    lost: int | None
    share: float
    worst: float
    worst_at: int

    @property
    def whole(self) -> bool:
        """Whether the series is followed to its end."""
        return self.lost is None


def following(
    measured: Series, residual: Series, sample_rate_hz: float, *, noise: float = 0.0, chance: float = 1.0
) -> Following:
    """Return how far a model follows a series.

    In every window of 50 ms the residual's mean square is at most

        max(0.5 m, 0.125 M, min(2 e, 0.5 M))^2 + chance noise^2

    with m the measured RMS in the window, M that of the whole series, and e the median of the residual's RMS in all
    windows: noise of any colour, and what a model lacks throughout, are no loss.

    Parameters
    ----------
    measured : Series of N samples
        Less what is projected out; 0 where a sample does not count.
    residual : Series of N samples
        Of the same samples; 0 where a sample does not count, NaN where the simulation failed.
    sample_rate_hz : float
    noise : float
        RMS of the noise in both.
    chance : float
        Mean square, in units of that of the noise, that noise reaches in a window by chance.

    Examples
    --------
    >>> t = np.arange(0.0, 1.0, 1e-3)
    >>> y = np.sin(100.0 * t)
    >>> following(y, 0.4 * y, 1000.0).whole, following(y, np.where(t < 0.6, 0.0, y), 1000.0).lost
    (True, 600)
    """
    starts = _starts(residual.size, max(round(SERIES.follow_window_s * sample_rate_hz), 4))
    ends = np.append(starts[1:], residual.size)
    there, left = _mean_squares(measured, residual, starts, ends)
    sizes = ends - starts
    whole = float(there @ sizes) / residual.size
    throughout = min(SERIES.throughout**2 * float(np.median(left)), SERIES.most_of_record**2 * whole)
    least = max(SERIES.of_record**2 * whole, throughout if math.isfinite(throughout) else 0.0)
    allowed = np.maximum(SERIES.of_window**2 * there, least) + chance * noise**2
    ratio = np.sqrt(left / np.maximum(allowed, np.finfo(float).tiny))
    ratio[~np.isfinite(ratio)] = math.inf
    lost = np.flatnonzero(ratio > 1.0)
    worst = int(np.argmax(ratio))
    return Following(
        lost=int(starts[lost[0]]) if lost.size else None,
        share=float(sizes[ratio <= 1.0].sum()) / residual.size,
        worst=float(ratio[worst]),
        worst_at=int(starts[worst]),
    )


def out_of_step(residual: Series, sample_rate_hz: float, full_step: float) -> int | None:
    """Return the first sample of the first window in which an angle has left the one modelled by two full steps.

    A motor that falls out of step comes to rest four full steps away, or a multiple; an offset is projected out, so
    that the first window is the one that is in step.

    Parameters
    ----------
    residual : Series of N samples
        Of an angle, rad.
    sample_rate_hz : float
    full_step : float
        In rad at the same shaft.
    """
    starts = _starts(residual.size, max(round(SERIES.follow_window_s * sample_rate_hz), 4))
    ends = np.append(starts[1:], residual.size)
    sums = np.concatenate([np.add.reduceat(residual[part], inside) for part, _, inside in _some(starts, ends)])
    means = sums / (ends - starts)
    lost = np.flatnonzero(~(np.abs(means - means[0]) < 2.0 * full_step))
    return int(starts[lost[0]]) if lost.size else None


def _starts(samples: int, window: int) -> IntArray:
    """Return where windows begin; what is left at the end goes with the last one."""
    return np.arange(max(samples // window, 1), dtype=np.int64) * window


def _some(starts: IntArray, ends: IntArray) -> Iterator[tuple[slice, slice, IntArray]]:
    """Yield the samples of some windows, which windows these are, and where they begin within the samples."""
    for k in range(0, starts.size, SERIES.block_windows):
        some = slice(k, min(k + SERIES.block_windows, starts.size))
        first = int(starts[k])
        yield slice(first, int(ends[some][-1])), some, starts[some] - first


def _mean_squares(
    measured: Series, residual: Series, starts: IntArray, ends: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Return the mean squares of both in each window, (w,) each, block by block."""
    there, left = np.empty(starts.size), np.empty(starts.size)
    for part, some, inside in _some(starts, ends):
        there[some] = np.add.reduceat(measured[part] ** 2, inside)
        left[some] = np.add.reduceat(residual[part] ** 2, inside)
    sizes = ends - starts
    return there / sizes, left / sizes
