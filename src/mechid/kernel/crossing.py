"""First zero of a margin within one step, for the slow twin."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from mechid.arrays import FloatArray

Margin = Callable[[FloatArray], FloatArray]

CHECKS = 16
"""Number of intervals per step at whose ends the margin is evaluated."""


def first_zero(margin: Margin, begin: float, end: float, armed: bool) -> tuple[float | None, bool]:
    """Return the first instant in [begin, end] at which a margin reaches zero, or None.

    A margin that is not armed has been at zero since its mode began. It may fire only after it has been above zero, or
    at once if it falls below zero without having been above.

    Returns
    -------
    instant : float or None
    armed : bool
        Whether the margin has been above zero by the end of the step.
    """
    times = np.linspace(begin, end, CHECKS + 1)
    values = margin(times)
    above = np.flatnonzero(values > 0.0)
    if not armed and not above.size:
        return (begin if np.any(values < 0.0) else None), False
    first = 0 if armed else int(above[0])
    for k in range(first + 1, CHECKS + 1):
        if values[k] <= 0.0:
            return _root(margin, times[k - 1], times[k]), True
        # A local minimum between two checks may dip below zero and rise again unnoticed.
        if k < CHECKS and values[k] < values[k - 1] and values[k] < values[k + 1]:
            lowest = _lowest(margin, times[k - 1], times[k + 1])
            if margin(np.array([lowest]))[0] <= 0.0:
                return _root(margin, times[k - 1], lowest), True
    return None, True


def _root(margin: Margin, above: float, below: float) -> float:
    def value(t: float) -> float:
        return float(margin(np.array([t]))[0])

    if value(above) <= 0.0:
        return float(above)
    # The relative tolerance alone decides: instants near 0 need as many digits as others.
    return float(brentq(value, above, below, xtol=1e-18, rtol=4 * np.finfo(float).eps))


def _lowest(margin: Margin, begin: float, end: float) -> float:
    found = minimize_scalar(
        lambda t: float(margin(np.array([t]))[0]),
        bounds=(begin, end),
        method="bounded",
        # Only the sign at the minimum counts, and a margin is flat there.
        options={"xatol": 1e-3 * (end - begin)},
    )
    return float(found.x)
