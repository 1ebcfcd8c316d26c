"""Weighted regression of estimates that have an error each, and scatter by more than their errors.

value_i = sum_k design_ik coefficient_k + u_i + e_i, u_i with one variance tau^2 (from unit to unit), e_i with its own
known sigma_i^2: the random-effects model of meta-analysis. tau^2 is that of Paule and Mandel [PM1982]_: it makes the
weighted sum of squares Q(tau^2) = sum_i (value_i - fitted_i)^2 / (sigma_i^2 + tau^2) equal to its expectation, the
degrees of freedom. Its interval is where Q lies between the quantiles of chi-square ([V2007]_, Q-profile). The
coefficients have (X' W X)^-1 and Student's t with the degrees of freedom: the method of Hartung, Knapp, Sidik and
Jonkman [HK2001]_, whose factor Q/dof is 1 where tau^2 is above 0, and is not let below 1 where it is 0.

.. [PM1982] R. C. Paule, J. Mandel, Consensus values and weighting factors, J. Res. Natl. Bur. Stand. 87 (1982) 377
.. [V2007] W. Viechtbauer, Confidence intervals for the amount of heterogeneity, Stat. Med. 26 (2007) 37
.. [HK2001] J. Hartung, G. Knapp, A refined method for the meta-analysis of controlled clinical trials, Stat. Med. 20
   (2001) 3875
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.stats import chi2, t

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Regression:
    """Coefficients with their errors, and the scatter about them beyond the errors of the values.

    Attributes
    ----------
    coefficients : (k,)
    covariance : (k, k)
    dof : int
        Number of values less k.
    scatter : float
        tau, in the unit of the values.
    scatter95 : (float, float)
        95 % interval of tau.
    equal_p : float
        Probability that the errors alone scatter the values as much (Cochran's Q).
    """

    coefficients: FloatArray
    covariance: FloatArray
    dof: int
    scatter: float
    scatter95: tuple[float, float]
    equal_p: float

    def error(self, k: int = 0) -> float:
        """Return the standard error of a coefficient."""
        return float(np.sqrt(self.covariance[k, k]))

    def reach(self, error: float) -> float:
        """Return half of a 95 % interval."""
        return error * float(t.ppf(0.975, self.dof))

    def interval(self, k: int = 0) -> tuple[float, float]:
        """Return the 95 % interval of a coefficient."""
        reach = self.reach(self.error(k))
        return float(self.coefficients[k]) - reach, float(self.coefficients[k]) + reach

    def p_value(self, k: int = 0) -> float:
        """Return the probability of a coefficient at least as large where the true one is 0, on either side."""
        return float(2.0 * t.sf(abs(self.coefficients[k]) / self.error(k), self.dof))


def regression(values: FloatArray, errors: FloatArray, design: FloatArray) -> Regression:
    """Return the regression of values on the columns of a design.

    Parameters
    ----------
    values, errors : (n,)
        Estimates and their standard errors, above 0, in one unit.
    design : (n, k)
        Of full rank, k < n.
    """
    unit = _size(values, errors, design)
    y, variance, dof = values / unit, np.square(errors / unit), values.size - design.shape[1]

    def weighted(tau2: float) -> float:
        return _fit(y, variance + tau2, design)[2]

    tau2 = _crossing(weighted, float(dof))
    coefficients, covariance, _ = _fit(y, variance + tau2, design)
    ends = (_crossing(weighted, float(chi2.ppf(share, dof))) for share in (0.975, 0.025))
    low, high = (unit * math.sqrt(end) for end in ends)
    return Regression(
        coefficients=unit * coefficients,
        covariance=unit**2 * covariance,
        dof=dof,
        scatter=unit * math.sqrt(tau2),
        scatter95=(low, high),
        equal_p=float(chi2.sf(weighted(0.0), dof)),
    )


def common(values: FloatArray, errors: FloatArray) -> Regression:
    """Return the regression on a constant: mean and spread of two values or more."""
    return regression(values, errors, np.ones((values.size, 1)))


def _size(values: FloatArray, errors: FloatArray, design: FloatArray) -> float:
    """Return what the numbers are counted in, so that tolerances mean the same for 1e-6 and 1e6."""
    left = values - design @ np.linalg.lstsq(design, values, rcond=None)[0]
    return float(max(np.sqrt(np.mean(np.square(left))), np.median(errors)))


def _fit(y: FloatArray, variance: FloatArray, design: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return coefficients, covariance and weighted sum of squares at known variances."""
    rows = design / np.sqrt(variance)[:, None]
    orthogonal, triangle = np.linalg.qr(rows)
    inverse = np.linalg.inv(triangle)
    coefficients = inverse @ (orthogonal.T @ (y / np.sqrt(variance)))
    left = (y - design @ coefficients) / np.sqrt(variance)
    return coefficients, inverse @ inverse.T, float(left @ left)


def _crossing(weighted: Callable[[float], float], wanted: float) -> float:
    """Return the tau^2 at which the weighted sum of squares falls to `wanted`; 0 where it is below from the start."""
    if weighted(0.0) <= wanted:
        return 0.0
    high = 1.0
    while weighted(high) > wanted:
        high *= 4.0
    return float(brentq(lambda tau2: weighted(tau2) - wanted, 0.0, high, xtol=1e-14, rtol=1e-12))
