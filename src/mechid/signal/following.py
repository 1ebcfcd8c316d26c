"""Window-by-window test of whether a model follows a measured series."""

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
    """Result of `assess_following`.

    Attributes
    ----------
    lost : int or None
        First sample of the first window that is not followed, or None if all are followed.
    share : float
        Share of the samples that lie in followed windows.
    worst : float
        Largest ratio of a window's residual RMS to its limit; infinite if the simulation failed.
    worst_at : int
        First sample of that window.
    """

    lost: int | None
    share: float
    worst: float
    worst_at: int

    @property
    def is_complete(self) -> bool:
        """Whether the model follows the series in all windows."""
        return self.lost is None


def assess_following(
    measured: Series, residual: Series, sample_rate_hz: float, *, noise: float = 0.0, chance: float = 1.0
) -> Following:
    """Test in which windows a model follows a measured series.

    A window of 50 ms is followed if the mean square of its residual is at most

        max(0.5 m, 0.125 M, min(2 e, 0.5 M))^2 + chance noise^2

    where m is the measured RMS in the window, M that of the whole series, and e the median of the residual's RMS over
    all windows. Noise of any colour, and model errors present throughout the series, are therefore tolerated.

    Parameters
    ----------
    measured : Series of N samples
        Measured series without the projected-out parts; 0 at rejected samples.
    residual : Series of N samples
        Residual at the same samples; 0 at rejected samples, NaN where the simulation failed.
    sample_rate_hz : float
    noise : float
        RMS of the noise in both series.
    chance : float
        Mean square that noise reaches in a window by chance, relative to the noise's mean square.

    Examples
    --------
    >>> t = np.arange(0.0, 1.0, 1e-3)
    >>> y = np.sin(100.0 * t)
    >>> assess_following(y, 0.4 * y, 1000.0).is_complete, assess_following(y, np.where(t < 0.6, 0.0, y), 1000.0).lost
    (True, 600)
    """
    starts = _window_starts(residual.size, max(round(SERIES.follow_window_s * sample_rate_hz), 4))
    ends = np.append(starts[1:], residual.size)
    there, left = _mean_squares(measured, residual, starts, ends)
    sizes = ends - starts
    whole = float(there @ sizes) / residual.size
    throughout = min(SERIES.throughout**2 * float(np.median(left)), SERIES.most_of_record**2 * whole)
    least = max(SERIES.of_record**2 * whole, throughout if math.isfinite(throughout) else 0.0)
    allowed = np.maximum(SERIES.of_window**2 * there, least) + chance * noise**2
    ratio = np.sqrt(left / np.maximum(allowed, np.finfo(float).tiny))
    # Comparisons with NaN are false: a window of a failed simulation would not count as lost.
    ratio[~np.isfinite(ratio)] = math.inf
    lost = np.flatnonzero(ratio > 1.0)
    worst = int(np.argmax(ratio))
    return Following(
        lost=int(starts[lost[0]]) if lost.size else None,
        share=float(sizes[ratio <= 1.0].sum()) / residual.size,
        worst=float(ratio[worst]),
        worst_at=int(starts[worst]),
    )


def first_out_of_step(residual: Series, sample_rate_hz: float, full_step: float) -> int | None:
    """Return the first sample of the first window in which the motor has lost synchronism, or None.

    A motor that loses synchronism settles at a multiple of four full steps from the commanded position. The limit is
    half of that: two full steps between the mean residual of a window and that of the first window, which serves as
    the reference because an offset has been projected out.

    Parameters
    ----------
    residual : Series of N samples
        Residual of an angle, in rad.
    sample_rate_hz : float
    full_step : float
        Full step in rad at the same shaft.
    """
    starts = _window_starts(residual.size, max(round(SERIES.follow_window_s * sample_rate_hz), 4))
    ends = np.append(starts[1:], residual.size)
    sums = np.concatenate([np.add.reduceat(residual[part], inside) for part, _, inside in _window_blocks(starts, ends)])
    means = sums / (ends - starts)
    # Negated so that NaN, a failed simulation, counts as lost.
    lost = np.flatnonzero(~(np.abs(means - means[0]) < 2.0 * full_step))
    return int(starts[lost[0]]) if lost.size else None


def _window_starts(samples: int, window: int) -> IntArray:
    """Return the first samples of the windows; the remainder at the end belongs to the last one."""
    return np.arange(max(samples // window, 1), dtype=np.int64) * window


def _window_blocks(starts: IntArray, ends: IntArray) -> Iterator[tuple[slice, slice, IntArray]]:
    """Yield the samples of a block of windows, the windows' indices, and their starts relative to the block."""
    for k in range(0, starts.size, SERIES.block_windows):
        some = slice(k, min(k + SERIES.block_windows, starts.size))
        first = int(starts[k])
        yield slice(first, int(ends[some][-1])), some, starts[some] - first


def _mean_squares(
    measured: Series, residual: Series, starts: IntArray, ends: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Return the mean squares of both series in each window, (w,) each, computed block by block."""
    there, left = np.empty(starts.size), np.empty(starts.size)
    for part, some, inside in _window_blocks(starts, ends):
        there[some] = np.add.reduceat(measured[part] ** 2, inside)
        left[some] = np.add.reduceat(residual[part] ** 2, inside)
    sizes = ends - starts
    return there / sizes, left / sizes
