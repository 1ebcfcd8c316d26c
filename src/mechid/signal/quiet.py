"""Quiet stretches: where a series is far below what it does elsewhere."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechid.signal.moments import standard_deviation
from mechid.signal.runs import runs_of
from mechid.signal.series import Series, blocks, stretch_of
from mechid.signal.stored import AT_ONCE

WINDOW_S, LEAST_SAMPLES = 0.02, 16
"""A stretch is looked at in windows of this length."""
LEAST_WINDOWS = 3
"""Of a stretch; a shorter one may be a signal that passes through zero."""
FAR_BELOW = 0.1
"""Of the RMS of the whole series: a quiet stretch, and the quietest window, lie below."""
ALIKE = 2.0
"""Times the RMS of the quietest window, up to which a window is quiet too."""

LIKE_THE_QUIETEST = 1.5
"""Times the RMS of the quietest stretch, up to which another is like it."""


@dataclass(frozen=True, kw_only=True)
class QuietStretch:
    """The samples from `first` to before `stop`, and their RMS about their own mean, in the series' unit."""

    first: int
    stop: int
    rms: float


def quiet_stretches(y: Series, sample_rate: float) -> tuple[QuietStretch, ...]:
    """Return the stretches in which nothing moves, in their order; none where no window stands out as quiet.

    Parameters
    ----------
    y : Series of N samples
        In any unit.
    sample_rate : float
        In Hz.
    """
    n = max(round(WINDOW_S * sample_rate), LEAST_SAMPLES)
    if y.size < 2 * LEAST_WINDOWS * n:
        return ()
    windows = blocks(y.size // n, max(AT_ONCE // n, 1))
    rms = np.concatenate([y[some.start * n : some.stop * n].reshape(-1, n).std(axis=1) for some in windows])
    least, whole = float(rms.min()), standard_deviation(y)
    if least > FAR_BELOW * whole:
        return ()
    found = runs_of(np.flatnonzero(rms <= ALIKE * least))
    long = ((a * n, b * n) for a, b in found if b - a >= LEAST_WINDOWS)
    stretches = (QuietStretch(first=a, stop=b, rms=standard_deviation(stretch_of(y, a, b))) for a, b in long)
    return tuple(one for one in stretches if one.rms <= FAR_BELOW * whole)  # a ramp is none


def quiet_rms(stretches: Sequence[QuietStretch]) -> float | None:
    """Return the RMS over the quietest stretch and those like it, None where there is none.

    What is louder may be a weak signal. Of coloured noise it is up to a quarter too low: windows near the quietest
    are picked.
    """
    least = min((one.rms for one in stretches), default=0.0)
    alike = [(one.stop - one.first, one.rms) for one in stretches if one.rms <= LIKE_THE_QUIETEST * least]
    if not alike:
        return None
    return math.sqrt(sum(n * rms**2 for n, rms in alike) / sum(n for n, _ in alike))
