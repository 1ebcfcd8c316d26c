"""Detection of quiet stretches, in which a series is far below its usual level."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechid.signal.moments import standard_deviation
from mechid.signal.runs import runs_of
from mechid.signal.series import Series, blocks, stretch_of
from mechid.signal.settings import SERIES
from mechid.signal.stored_series import AT_ONCE


@dataclass(frozen=True, kw_only=True)
class QuietStretch:
    """Samples from `first` to before `stop`, and their RMS about their mean, in the series' unit."""

    first: int
    stop: int
    rms: float


def quiet_stretches(y: Series, sample_rate: float) -> tuple[QuietStretch, ...]:
    """Return the stretches without motion, in order; empty if no window is clearly quieter than the series.

    Parameters
    ----------
    y : Series of N samples
        In any unit.
    sample_rate : float
        In Hz.
    """
    n = max(round(SERIES.quiet_window_s * sample_rate), SERIES.least_samples)
    if y.size < 2 * SERIES.least_windows * n:
        return ()
    windows = blocks(y.size // n, max(AT_ONCE // n, 1))
    rms = np.concatenate([y[some.start * n : some.stop * n].reshape(-1, n).std(axis=1) for some in windows])
    least, whole = float(rms.min()), standard_deviation(y)
    if least > SERIES.far_below * whole:
        return ()
    found = runs_of(np.flatnonzero(rms <= SERIES.quiet_alike * least))
    long = ((a * n, b * n) for a, b in found if b - a >= SERIES.least_windows)
    stretches = (QuietStretch(first=a, stop=b, rms=standard_deviation(stretch_of(y, a, b))) for a, b in long)
    # The windows of a slow ramp are all quiet, but the ramp as a whole is not.
    return tuple(one for one in stretches if one.rms <= SERIES.far_below * whole)


def quiet_rms(stretches: Sequence[QuietStretch]) -> float | None:
    """Return the RMS over the quietest stretch and those of a similar level, or None if there are no stretches.

    Louder stretches are excluded because they may contain a weak signal. For coloured noise the result is up to a
    quarter too low, because it selects the quietest windows.
    """
    least = min((one.rms for one in stretches), default=0.0)
    alike = [(one.stop - one.first, one.rms) for one in stretches if one.rms <= SERIES.like_the_quietest * least]
    if not alike:
        return None
    return math.sqrt(sum(n * rms**2 for n, rms in alike) / sum(n for n, _ in alike))
