"""Confidence bounds of line amplitudes and of powers, from noise and from a background.

A line of amplitude A in noise: the sum t of W independent periodogram values over half the noise level follows a
noncentral chi-square distribution with 2 W degrees of freedom and noncentrality 2 W A^2 / v, v the mean periodogram of
the noise. Its inversion has no Rice bias. A power with relative variance 2 / nu is bounded as a chi-square value with
nu degrees of freedom. Bounds of a difference of two powers come from the bounds of each (method of variance estimates
recovery: Zou and Donner, Statistics in Medicine 27, 2008, pp. 1693-1702).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.special import chndtr, gammainccinv, gammaincinv, ndtri

from mechid.arrays import FloatArray

FAR = 30.0
"""Root of the noncentrality beyond which the root of t is normal to 1e-3 of its scatter."""
KNOTS = 240
"""Of the table of noncentralities: linear between them it is off by 1e-3 of the scatter."""


def line_bounds(ratio: FloatArray, windows: int, alpha: float) -> tuple[FloatArray, FloatArray]:
    """Return bounds of A^2 / v of a line, each missed with probability `alpha`.

    Parameters
    ----------
    ratio : ndarray, shape (n,)
        Mean periodogram over the windows, over that of the noise.
    windows : int
        Independent windows W.
    alpha : float
        One-sided.

    Returns
    -------
    lower, upper : ndarray, shape (n,)

    Examples
    --------
    >>> lower, upper = line_bounds(np.array([1.0, 100.0]), 8, 0.025)
    >>> lower.round(1).tolist(), upper.round(1).tolist()
    ([0.0, 89.5], [1.1, 109.1])
    """
    root = np.sqrt(2.0 * windows * np.maximum(ratio, 0.0))
    found = []
    for sign in (1.0, -1.0):
        at, values = _table(windows, alpha, sign)
        near = np.interp(root, at, values)
        # Far out, the root of t is normal with variance 1 about sqrt(noncentrality + 2 W - 1).
        far = np.sqrt(np.maximum(root**2 - 2.0 * windows + 1.0, 0.0)) - sign * float(ndtri(1.0 - alpha))
        chosen = np.where(root < at[-1], near, np.maximum(far, 0.0))
        found.append(chosen**2 / (2.0 * windows))
    return found[0], found[1]


@lru_cache(maxsize=256)
def _table(windows: int, alpha: float, sign: float) -> tuple[FloatArray, FloatArray]:
    """Return roots of t, ascending, and of the noncentralities that they bound from below (1) or from above (-1)."""
    noncentral = np.linspace(0.0, FAR, KNOTS)
    z = float(ndtri(1.0 - alpha))
    low = np.zeros(KNOTS)
    # Beyond the quantile: the root of t exceeds the sum of both roots by little more than z.
    high = (noncentral + np.sqrt(2.0 * windows) + z + 4.0) ** 2
    wanted = 1.0 - alpha if sign > 0.0 else alpha
    for _ in range(60):  # the quantile by bisection: SciPy's own inverse fails in far tails
        middle = 0.5 * (low + high)
        above = chndtr(middle, 2.0 * windows, noncentral**2) < wanted
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    roots = np.sqrt(0.5 * (low + high))
    # A sum below the quantile of noise alone has the upper bound 0; the table is continued to the origin.
    return (roots, noncentral) if sign > 0.0 else (np.append(0.0, roots), np.append(0.0, noncentral))


def power_bounds(
    power: FloatArray, dof: FloatArray, alpha_lower: float, alpha_upper: float
) -> tuple[FloatArray, FloatArray]:
    """Return bounds of powers that are chi-square values with so many degrees of freedom, (n,) each.

    Examples
    --------
    >>> [bound.round(3).tolist() for bound in power_bounds(np.array([1.0]), np.array([10.0]), 0.025, 0.025)]
    [[0.488], [3.08]]
    """
    # The inverse gamma functions need degrees of freedom above 0.
    half = np.maximum(0.5 * np.asarray(dof, dtype=np.float64), 1e-3)
    lower = power * half / gammainccinv(half, alpha_lower)
    upper = power * half / gammaincinv(half, alpha_upper)
    return np.asarray(lower, dtype=np.float64), np.asarray(upper, dtype=np.float64)


def difference_bounds(
    of: tuple[FloatArray, FloatArray, FloatArray], less: tuple[FloatArray, FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return a difference of two powers and its bounds; each is given as power, lower and upper bound."""
    power, lower, upper = of
    other, other_lower, other_upper = less
    difference = power - other
    below = difference - np.hypot(power - lower, other_upper - other)
    above = difference + np.hypot(upper - power, other - other_lower)
    return difference, below, above
