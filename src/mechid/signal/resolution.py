"""Amplitude resolution of samples: the step of a converter, of a counter, or of printed digits."""

from __future__ import annotations

import numpy as np

from mechid.signal.series import Series
from mechid.signal.stored_series import pieces_of

MULTIPLE_TOLERANCE = 1e-3
"""Maximum distance of a sample from a whole number of steps, in steps."""
LEAST_REPETITIONS = 4
"""Least average number of samples per level; samples that rarely repeat do not reveal a step."""
ROUNDING = 1e-12
"""Levels closer than this, relative to the largest sample, are considered equal."""


def resolution(y: Series) -> float:
    """Return the step of which all samples are whole multiples, apart from a constant; 0 if there is none.

    Parameters
    ----------
    y : Series of N samples
        In any unit.

    Examples
    --------
    >>> resolution(np.round(np.sin(np.arange(1000.0)), 2))
    0.01
    """
    levels = np.zeros(0)
    for part in pieces_of(y):
        levels = np.union1d(levels, y[part])
        if LEAST_REPETITIONS * levels.size > y.size:
            return 0.0
    apart = np.diff(levels)
    apart = apart[apart > ROUNDING * float(np.abs(levels[[0, -1]]).max())]
    if not apart.size:
        return 0.0
    step = float(apart.min())
    steps = (levels - levels[0]) / step
    # The full range divided by its number of steps has a smaller relative error than the smallest difference.
    step *= float(steps[-1] / np.rint(steps[-1]))
    off = np.abs(steps - np.rint(steps))
    return float(f"{step:.9g}") if float(off.max()) < MULTIPLE_TOLERANCE * max(float(steps[-1]), 1.0) ** 0.5 else 0.0
