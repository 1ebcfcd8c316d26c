"""Test of the whiteness of a residual, and its effective number of independent samples."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.fft import prev_fast_len
from scipy.special import chdtrc

from mechid.arrays import FloatArray, IntArray
from mechid.signal.autoregression import autocovariance, autocovariance_of_accepted
from mechid.signal.series import Series, mean_of
from mechid.signal.transform import transform_blocks

LAGS = 25


@dataclass(frozen=True, kw_only=True)
class LjungBox:
    """Result of the Ljung-Box test for autocorrelation at lags 1 to `lags`.

    Attributes
    ----------
    statistic : float
        Q, which for a white series follows a chi-square distribution with `lags` degrees of freedom.
    lags : int
    p_value : float
        Probability of this Q or a larger one for a white series.
    largest : float
        Autocorrelation of the largest magnitude among the lags. In contrast to the p-value, it does not depend on the
        number of samples.
    """

    statistic: float
    lags: int
    p_value: float
    largest: float


def ljung_box(series: Series, lags: int = LAGS, rejected: IntArray | None = None) -> LjungBox:
    """Perform the Ljung-Box test, Q = n (n + 2) sum_k rho_k^2 / (n - k) [LjungBox1978]_.

    Degrees of freedom are not reduced by fitted parameters, because the parameters of an output-error model are not
    those of an ARMA model of the series.

    Parameters
    ----------
    series : Series of N samples
        The mean is removed.
    lags : int
        Number of lags, limited to N - 1.
    rejected : ndarray of int, shape (M,), or None
        Indices of samples to exclude.

    Returns
    -------
    LjungBox
        With NaN if the series is constant or not finite.

    References
    ----------
    .. [LjungBox1978] G. M. Ljung, G. E. P. Box, Biometrika 65 (1978) 297-303, doi:10.1093/biomet/65.2.297.
    """
    n = series.size
    lags = min(lags, n - 1)
    if rejected is not None and rejected.size:
        n, covariance = autocovariance_of_accepted(series, lags, rejected)
    else:
        covariance = autocovariance(series, lags, mean_of(series))
    if not covariance[0] > 0.0 or lags < 1:
        return LjungBox(statistic=math.nan, lags=lags, p_value=math.nan, largest=math.nan)
    rho = covariance[1:] / covariance[0]
    statistic = n * (n + 2) * float(np.sum(rho**2 / (n - np.arange(1, lags + 1))))
    largest = float(rho[np.argmax(np.abs(rho))])
    return LjungBox(statistic=statistic, lags=lags, p_value=float(chdtrc(lags, statistic)), largest=largest)


def effective_samples(series: Series) -> float:
    """Return the number of independent samples whose sum of squares is as uncertain as that of a series.

    Autocorrelation increases the variance of a sum of squares by the sum of rho_k^2 over all positive and negative
    lags, so n_eff = n / sum_k rho_k^2 [Bayley1946]_. By Parseval's theorem the sum equals
    n sum_j S_j^2 / (sum_j S_j)^2 over the spectrum. The squared periodogram is twice S_j^2 on average, because its
    ordinates are exponentially distributed.

    Parameters
    ----------
    series : Series of N samples
        The mean is removed.

    Returns
    -------
    float
        From 1 to N; NaN if the series is constant or not finite.

    References
    ----------
    .. [Bayley1946] G. V. Bayley, J. M. Hammersley, Suppl. J. R. Stat. Soc. 8 (1946) 184-197, doi:10.2307/2983560.
    """
    # A few samples are dropped to avoid the transform of a prime length, which is slow.
    size = int(prev_fast_len(series.size, real=True))
    total = squares = 0.0
    for numbers, bins in transform_blocks(series, size, mean_of(series, size)):
        both_signs = bins[(numbers > 0) & (2 * numbers < size)]
        power = both_signs.real**2 + both_signs.imag**2
        total, squares = total + float(power.sum()), squares + float(np.sum(power**2))
    if not total > 0.0:
        return math.nan
    return min(max(_effective_share(total, squares, size) * series.size, 1.0), float(series.size))


def effective_samples_of(amplitude: FloatArray, samples: int) -> float:
    """Return the same as `effective_samples`, from a spectrum that is available already.

    Parameters
    ----------
    amplitude : ndarray, shape (N // 2 + 1,)
        Single-sided amplitude spectrum of N samples without a window.
    samples : int
        N.
    """
    power = amplitude[1 : (samples + 1) // 2] ** 2
    total, squares = float(power.sum()), float(np.sum(power**2))
    if not total > 0.0:
        return math.nan
    return min(max(_effective_share(total, squares, samples) * samples, 1.0), float(samples))


def _effective_share(total: float, squares: float, size: int) -> float:
    """Return the effective share of samples from the sums of the periodogram's ordinates and of their squares."""
    return 4.0 * total**2 / squares / size
