"""Units that stand off from all others of a parameter by more than its spread and their own errors.

One unit after the other is taken out, the one farthest off first: at most a quarter of all. Each is tested by how far
it lies from the mean of those left, in the error of that distance (its own error, the spread and the error of the mean
of the others: deleted residual, [VC2010]_), with Student's t of those left and Bonferroni's factor for the choice
of the farthest. All taken out up to the last that is significant are outliers, as in Rosner's procedure [R1983]_: so
two that stand off on the same side do not hide one another.

.. [VC2010] W. Viechtbauer, M. W.-L. Cheung, Outlier and influence diagnostics, Res. Synth. Methods 1 (2010) 112
.. [R1983] B. Rosner, Percentage points for a generalized ESD many-outlier procedure, Technometrics 25 (1983) 165
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t

from mechid.fleets.regression import common

FloatArray = NDArray[np.float64]
LEAST = 4
"""Units at least; of fewer none can stand off from the others."""
SHARE = 4
"""At most one in so many may be an outlier."""


@dataclass(frozen=True)
class Standing:
    """How far a unit stands off, in the error of that distance, and the probability of that by chance."""

    unit: int
    off: float
    p_value: float


def farthest(values: FloatArray, errors: FloatArray) -> tuple[Standing, ...]:
    """Return the units that may be outliers, the farthest first; none of fewer than four.

    Parameters
    ----------
    values, errors : (n,)
        Estimates of the units and their standard errors.
    """
    if values.size < LEAST:
        return ()
    left, found = list(range(values.size)), []
    for _ in range(values.size // SHARE):
        offs = [_off(values, errors, left, unit) for unit in left]
        k = int(np.argmax(np.abs(offs)))
        chance = 2.0 * float(t.sf(abs(offs[k]), len(left) - 2)) * len(left)
        found.append(Standing(left[k], offs[k], min(chance, 1.0)))
        left.pop(k)
    least = np.minimum.accumulate([one.p_value for one in found][::-1])[::-1]
    return tuple(Standing(one.unit, one.off, float(p)) for one, p in zip(found, least, strict=True))


def _off(values: FloatArray, errors: FloatArray, left: list[int], unit: int) -> float:
    """Return the distance of a unit from the mean of the others, in the error of that distance."""
    others = [k for k in left if k != unit]
    mean = common(values[others], errors[others])
    error = np.sqrt(errors[unit] ** 2 + mean.scatter**2 + mean.error() ** 2)
    return float((values[unit] - mean.coefficients[0]) / error)
