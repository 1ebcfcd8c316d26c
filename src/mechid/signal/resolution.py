"""The step in which samples are written: that of a converter, of a counter, or of printed digits."""

from __future__ import annotations

import numpy as np

from mechid.signal.series import Series
from mechid.signal.stored import pieces_of

WHOLE = 1e-3
"""Of a step: how far a sample may be off a whole number of them."""
REPEATED = 4
"""So many samples a level on average; samples that hardly ever repeat tell no step."""
ROUNDING = 1e-12
"""Of the largest sample: levels nearer to one another than this are one."""


def resolution(y: Series) -> float:
    """Return the step that all samples are whole multiples of, apart from a constant; 0 where there is none.

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
        if REPEATED * levels.size > y.size:
            return 0.0
    apart = np.diff(levels)
    apart = apart[apart > ROUNDING * float(np.abs(levels[[0, -1]]).max())]
    if not apart.size:
        return 0.0
    step = float(apart.min())
    steps = (levels - levels[0]) / step
    step *= float(steps[-1] / np.rint(steps[-1]))
    off = np.abs(steps - np.rint(steps))
    return float(f"{step:.9g}") if float(off.max()) < WHOLE * max(float(steps[-1]), 1.0) ** 0.5 else 0.0
