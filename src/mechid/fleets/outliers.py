"""Outlying units of a parameter, which differ from all others by more than the spread and their own errors.

Units are removed in sequence, the farthest first: at most a fifth of all, and three. Each is tested by its distance
from the mean of the remaining ones, in units of that distance's error (its own error, the spread and the error of the
mean of the others: deleted residual, [VC2010]_), with Student's t and a Bonferroni factor for the choice of the
farthest. All units removed up to the last significant one are outliers, as in Rosner's procedure [R1983]_, so that two
outliers on the same side do not mask each other.

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
"""Least number of units for which an outlier can be identified."""
SHARE, MOST = 5, 3
"""One unit in `SHARE` at most may be an outlier, and `MOST` in all; each further one weakens the tests before it."""


@dataclass(frozen=True)
class Standing:
    """Distance of a unit from the others in units of its error, and its p-value."""

    unit: int
    off: float
    p_value: float


def farthest(values: FloatArray, errors: FloatArray) -> tuple[Standing, ...]:
    """Return candidate outliers, the farthest first; empty for fewer than four units.

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
    # A unit is at least as significant as those removed after it (Rosner).
    least = np.minimum.accumulate([one.p_value for one in found][::-1])[::-1]
    return tuple(Standing(one.unit, one.off, float(p)) for one, p in zip(found, least, strict=True))


def deleted_residuals(values: FloatArray, errors: FloatArray) -> FloatArray:
    """Return the distance of each unit from the mean of all others, in units of that distance's error.

    Mean and spread of the others are those of `regression.random_effects_mean`, for all units at once.

    Parameters
    ----------
    values, errors : (n,)
        n of three or more.
    """
    # Row i holds weight 0 for unit i and 1 for the others: all deletions are solved in one iteration.
    # Each q is expected to equal its degrees of freedom: n - 1 values less one mean.
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
        # Newton's step on 1/Q, as in `regression`: it stays short of the root.
        tau2[beyond] += q[beyond] * (q[beyond] / wanted - 1.0) / fall
    off: FloatArray = (values - means) / np.sqrt(np.square(errors) + tau2 + 1.0 / total)
    return off
