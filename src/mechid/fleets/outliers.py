"""Units that stand off from all others of a parameter by more than its spread and their own errors.

One unit after the other is taken out, the one farthest off first: at most a fifth of all, and three. Each is tested
by how far it lies from the mean of those left, in the error of that distance (its own error, the spread and the error
of the mean of the others: deleted residual, [VC2010]_), with Student's t of those left and Bonferroni's factor for the
choice of the farthest. All taken out up to the last that is significant are outliers, as in Rosner's procedure
[R1983]_: so two that stand off on the same side do not hide one another.

.. [VC2010] W. Viechtbauer, M. W.-L. Cheung, Outlier and influence diagnostics, Res. Synth. Methods 1 (2010) 112
.. [R1983] B. Rosner, Percentage points for a generalized ESD many-outlier procedure, Technometrics 25 (1983) 165
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr

from mechid.arrays import FloatArray
from mechid.fleets.regression import EXACT, STEPS

LEAST = 4
"""Units at least; of fewer none can stand off from the others."""
SHARE, MOST = 5, 3
"""At most one in so many may stand off, and so many; each more would cost those before it."""


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
    left, found = np.arange(values.size), []
    for _ in range(max(min(values.size // SHARE, MOST), 1)):
        offs = deleted_residuals(values[left], errors[left])
        k = int(np.argmax(np.abs(offs)))
        chance = 2.0 * float(stdtr(left.size - 2, -abs(offs[k]))) * left.size
        found.append(Standing(int(left[k]), float(offs[k]), min(chance, 1.0)))
        left = np.delete(left, k)
    least = np.minimum.accumulate([one.p_value for one in found][::-1])[::-1]
    return tuple(Standing(one.unit, one.off, float(p)) for one, p in zip(found, least, strict=True))


def deleted_residuals(values: FloatArray, errors: FloatArray) -> FloatArray:
    """Return the distance of each unit from the mean of all others, in the error of that distance.

    The mean and the spread of the others are those of `regression.common`, for all units at once.

    Parameters
    ----------
    values, errors : (n,)
        n of three or more.
    """
    others, tau2, wanted = 1.0 - np.eye(values.size), np.zeros(values.size), values.size - 2.0
    for _ in range(STEPS):
        weights = others / (np.square(errors) + tau2[:, None])
        total = weights.sum(axis=1)
        means = weights @ values / total
        terms = weights * np.square(values - means[:, None])
        q = terms.sum(axis=1)
        beyond = q > wanted * (1.0 + EXACT)
        if not beyond.any():
            break
        fall = (weights * terms).sum(axis=1)[beyond]
        tau2[beyond] += q[beyond] * (q[beyond] / wanted - 1.0) / fall
    off: FloatArray = (values - means) / np.sqrt(np.square(errors) + tau2 + 1.0 / total)
    return off
