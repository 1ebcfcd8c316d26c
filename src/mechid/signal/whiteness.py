"""Whether a residual is white, and how many independent samples it is worth where it is not."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.fft import prev_fast_len
from scipy.special import chdtrc

from mechid.arrays import FloatArray, IntArray
from mechid.signal.autoregression import autocovariance, autocovariance_among
from mechid.signal.series import Series, mean_of
from mechid.signal.transform import transformed

LAGS = 25


@dataclass(frozen=True, kw_only=True)
class LjungBox:
    """The Ljung-Box test that the autocorrelation at lags 1 to `lags` is nothing but chance.

    Attributes
    ----------
    statistic : float
        Q; for a white series chi-square with `lags` degrees of freedom.
    lags : int
    p_value : float
        Chance of such a Q or a larger one from a white series.
    largest : float
        Autocorrelation of the largest magnitude among the lags: what p, which falls with the number of
        samples, does not tell.
    """

    statistic: float
    lags: int
    p_value: float
    largest: float


def ljung_box(series: Series, lags: int = LAGS, rejected: IntArray | None = None) -> LjungBox:
    """Return the test of Ljung and Box, Q = n (n + 2) sum_k rho_k^2 / (n - k) [LjungBox1978]_.

    No degree of freedom is taken off for fitted parameters: those of an output-error model of many
    samples are not those of an ARMA model of the series.

    Parameters
    ----------
    series : Series of N samples
        Its mean is removed.
    lags : int
        At most N - 1 are used.
    rejected : ndarray of int, shape (M,), or None
        Samples that do not count.

    Returns
    -------
    LjungBox
        NaN where the series is constant or not finite.

    References
    ----------
    .. [LjungBox1978] G. M. Ljung, G. E. P. Box, Biometrika 65 (1978) 297-303, doi:10.1093/biomet/65.2.297.
    """
    n = series.size
    lags = min(lags, n - 1)
    if rejected is not None and rejected.size:
        n, covariance = autocovariance_among(series, lags, rejected)
    else:
        covariance = autocovariance(series, lags, mean_of(series))
    if not covariance[0] > 0.0 or lags < 1:
        return LjungBox(statistic=math.nan, lags=lags, p_value=math.nan, largest=math.nan)
    rho = covariance[1:] / covariance[0]
    statistic = n * (n + 2) * float(np.sum(rho**2 / (n - np.arange(1, lags + 1))))
    largest = float(rho[np.argmax(np.abs(rho))])
    return LjungBox(statistic=statistic, lags=lags, p_value=float(chdtrc(lags, statistic)), largest=largest)


def effective_samples(series: Series) -> float:
    """Return how many independent samples give a sum of squares as uncertain as this series does.

    The variance of a sum of squares grows by the sum of rho_k^2 over all lags of both signs, so
    n_eff = n / sum_k rho_k^2 [Bayley1946]_. By Parseval the sum is n sum_j S_j^2 / (sum_j S_j)^2 over the
    spectrum, and the squared periodogram is twice S_j^2 on average, its ordinates being exponentially
    distributed.

    Parameters
    ----------
    series : Series of N samples
        Its mean is removed.

    Returns
    -------
    float
        From 1 to N; NaN where the series is constant or not finite.

    References
    ----------
    .. [Bayley1946] G. V. Bayley, J. M. Hammersley, Suppl. J. R. Stat. Soc. 8 (1946) 184-197, doi:10.2307/2983560.
    """
    size = int(prev_fast_len(series.size, real=True))  # a few samples less, and no transform of prime length
    total = squares = 0.0
    for numbers, bins in transformed(series, size, mean_of(series, size)):
        both_signs = bins[(numbers > 0) & (2 * numbers < size)]
        power = both_signs.real**2 + both_signs.imag**2
        total, squares = total + float(power.sum()), squares + float(np.sum(power**2))
    if not total > 0.0:
        return math.nan
    return min(max(_share(total, squares, size) * series.size, 1.0), float(series.size))


def effective_samples_of(amplitude: FloatArray, samples: int) -> float:
    """Return the same as `effective_samples` from a spectrum that has been worked out already.

    Parameters
    ----------
    amplitude : ndarray, shape (N // 2 + 1,)
        Single-sided amplitude spectrum of N samples under no window.
    samples : int
        N.
    """
    power = amplitude[1 : (samples + 1) // 2] ** 2
    total, squares = float(power.sum()), float(np.sum(power**2))
    if not total > 0.0:
        return math.nan
    return min(max(_share(total, squares, samples) * samples, 1.0), float(samples))


def _share(total: float, squares: float, size: int) -> float:
    """Return the effective share of `size` samples from sums over the ordinates of their periodogram."""
    return 4.0 * total**2 / squares / size
