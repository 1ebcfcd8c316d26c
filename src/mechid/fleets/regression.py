"""Weighted regression of estimates with individual errors and additional scatter (random-effects model).

The random-effects model of meta-analysis is value_i = sum_k design_ik coefficient_k + u_i + e_i, where u_i has a common
variance tau^2 (from unit to unit) and e_i a known variance sigma_i^2. tau^2 is estimated by Paule and Mandel [PM1982]_:
it makes the weighted sum of squares Q(tau^2) = sum_i (value_i - fitted_i)^2 / (sigma_i^2 + tau^2) equal to its
expectation, the degrees of freedom. Its interval is the range in which Q lies between quantiles of chi-square
([V2007]_, Q-profile). The coefficients have the covariance (X' W X)^-1 and Student's t with the degrees of freedom: the
method of Hartung, Knapp, Sidik and Jonkman [HK2001]_, whose factor Q/dof is 1 for tau^2 above 0, and is limited to at
least 1 for tau^2 of 0.

.. [PM1982] R. C. Paule, J. Mandel, Consensus values and weighting factors, J. Res. Natl. Bur. Stand. 87 (1982) 377
.. [V2007] W. Viechtbauer, Confidence intervals for the amount of heterogeneity, Stat. Med. 26 (2007) 37
.. [HK2001] J. Hartung, G. Knapp, A refined method for the meta-analysis of controlled clinical trials, Stat. Med. 20
   (2001) 3875
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.optimize import brentq
from scipy.special import chdtrc, chdtri, ndtr, ndtri, stdtr, stdtrit

from mechid.arrays import FloatArray

EXACT, STEPS = 1e-12, 100
"""Relative accuracy of the weighted sum of squares, and largest number of Newton steps."""
QUANTILES, FAR = 60, 40.0
"""Number of quantiles of tau^2 in a mixture, and number of widths that contain the whole mixture."""


@dataclass(frozen=True, kw_only=True)
class Regression:
    """Coefficients with their errors, and the scatter beyond the errors of the values.

    Attributes
    ----------
    coefficients : (k,)
    covariance : (k, k)
    dof : int
        Number of values minus k.
    scatter : float
        tau, in the unit of the values.
    scatter95 : (float, float)
        95 % interval of tau.
    equal_p : float
        Probability of at least this scatter from the errors alone (Cochran's Q).
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

    def interval(self, k: int = 0) -> tuple[float, float]:
        """Return the 95 % interval of a coefficient."""
        reach = self.error(k) * float(stdtrit(self.dof, 0.975))
        return float(self.coefficients[k]) - reach, float(self.coefficients[k]) + reach

    def p_value(self, k: int = 0) -> float:
        """Return the two-sided p-value of a coefficient."""
        return float(2.0 * stdtr(self.dof, -abs(self.coefficients[k]) / self.error(k)))


def regression(values: FloatArray, errors: FloatArray, design: FloatArray) -> Regression:
    """Return the regression of values on the columns of a design.

    Parameters
    ----------
    values, errors : (n,)
        Estimates and their standard errors, above 0, in one unit.
    design : (n, k)
        Of full rank, k < n.
    """
    weighted, dof = _Weighted.of(values, np.square(errors), design), values.size - design.shape[1]
    # Q falls with tau^2, so the upper quantile of Q gives the lower limit of tau^2.
    tau2, *ends = weighted.crossings(np.array([dof, *chdtri(dof, [0.025, 0.975])]))
    coefficients, covariance = _fit(values, np.square(errors) + tau2, design)
    return Regression(
        coefficients=coefficients,
        covariance=covariance,
        dof=dof,
        scatter=math.sqrt(tau2),
        scatter95=(math.sqrt(ends[0]), math.sqrt(ends[1])),
        equal_p=float(chdtrc(dof, weighted.at(np.zeros(1))[0][0])),
    )


def random_effects_mean(values: FloatArray, errors: FloatArray) -> Regression:
    """Return the regression on a constant: mean and spread of two values or more."""
    return regression(values, errors, np.ones((values.size, 1)))


def prediction_interval95(values: FloatArray, errors: FloatArray) -> tuple[float, float]:
    """Return the 95 % prediction interval of a further value without an error.

    The uncertainty of tau^2 is its confidence distribution by the Q-profile; the interval is that of the mixture of
    normal distributions over it (Nagashima, Noma, Furukawa, Stat. Methods Med. Res. 28 (2019) 1689, without draws).
    With tau^2 at its estimate alone the coverage would be 82 to 90 % if spread and errors are similar.
    """
    dof = values.size - 1
    weighted = _Weighted.of(values, np.square(errors), np.ones((values.size, 1)))
    # Midpoints of equally likely parts of tau^2's confidence distribution.
    shares = (np.arange(QUANTILES) + 0.5) / QUANTILES
    tau2 = weighted.crossings(chdtri(dof, shares))
    weights = 1.0 / (np.square(errors) + tau2[:, None])
    means = weights @ values / weights.sum(axis=1)
    # The error of the mean is widened to the 95 % interval of Student's t.
    widths = np.sqrt(tau2 + (stdtrit(dof, 0.975) / ndtri(0.975)) ** 2 / weights.sum(axis=1))

    def excess(value: float, share: float) -> float:
        return float(ndtr((value - means) / widths).mean()) - share

    far = FAR * widths.max()
    low, high = (
        float(brentq(excess, means.min() - far, means.max() + far, args=(share,), xtol=1e-9 * widths.min()))
        for share in (0.025, 0.975)
    )
    return low, high


@dataclass(frozen=True)
class _Weighted:
    """Q as a function of tau^2: sum squares / (variances + tau^2), in the eigenvectors of the design's complement."""

    squares: FloatArray
    variances: FloatArray

    @classmethod
    def of(cls, values: FloatArray, variance: FloatArray, design: FloatArray) -> Self:
        # The complement of the design: projecting on it removes the coefficients, so that Q depends on tau^2 alone.
        left = np.linalg.qr(design, mode="complete")[0][:, design.shape[1] :]
        variances, vectors = np.linalg.eigh(left.T @ (variance[:, None] * left))
        return cls(np.square(vectors.T @ (left.T @ values)), variances)

    def at(self, tau2: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return Q and minus its derivative at given tau^2."""
        terms = self.squares / (self.variances + tau2[:, None])
        return terms.sum(axis=1), (terms / (self.variances + tau2[:, None])).sum(axis=1)

    def crossings(self, wanted: FloatArray) -> FloatArray:
        """Return the tau^2 at which Q falls to each of `wanted`; 0 if Q starts below it.

        Newton's method is applied to 1/Q, which is concave: starting from 0, each step stays short of the root.
        """
        tau2 = np.zeros(wanted.size)
        for _ in range(STEPS):
            q, fall = self.at(tau2)
            beyond = q > wanted * (1.0 + EXACT)
            if not beyond.any():
                break
            tau2[beyond] += (q * (q / wanted - 1.0))[beyond] / fall[beyond]
        return tau2


def _fit(y: FloatArray, variance: FloatArray, design: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return coefficients and covariance at known variances."""
    # QR instead of normal equations, whose condition number is squared.
    orthogonal, triangle = np.linalg.qr(design / np.sqrt(variance)[:, None])
    inverse = np.linalg.inv(triangle)
    return inverse @ (orthogonal.T @ (y / np.sqrt(variance))), inverse @ inverse.T
