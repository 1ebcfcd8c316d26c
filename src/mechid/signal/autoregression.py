"""Autoregressive models of coloured residuals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz

FloatArray = NDArray[np.float64]
BLOCK = 65536


@dataclass(frozen=True)
class Autoregression:
    """r_k + a_1 r_(k-1) + ... + a_n r_(k-n) = e_k, e white with standard deviation `sigma`.

    `coefficients` is (n + 1,) with the leading one; order 0 means that the series is white already.
    """

    coefficients: FloatArray
    sigma: float

    @property
    def order(self) -> int:
        """Number of past samples that matter."""
        return self.coefficients.size - 1


def autocovariance(series: FloatArray, lags: int, mean: float = 0.0) -> FloatArray:
    """Return the biased autocovariance of a series about `mean`, at lags 0 to `lags` or as many as there are."""
    n, most = series.size, min(lags, series.size - 1)
    total = np.zeros(most + 1)
    for start in range(0, n, BLOCK):  # a long series is never copied whole
        size = min(BLOCK, n - start)
        ahead = np.zeros(size + most)
        part = series[start : start + size + most]
        ahead[: part.size] = part - mean
        total += [ahead[:size] @ ahead[k : k + size] for k in range(most + 1)]
    return total / n


def autocorrelation(series: FloatArray, lags: int) -> FloatArray:
    """Return the autocorrelation at lags 0 to `lags`, (lags + 1,), mean removed; NaN of a constant series."""
    covariance = autocovariance(series - np.mean(series), lags)
    return np.asarray(covariance / covariance[0], dtype=np.float64)


def fit_autoregression(series: FloatArray, most: int = 40, rejected: NDArray[np.int64] | None = None) -> Autoregression:
    """Return the Yule-Walker model whose order, up to `most`, minimises the Bayesian criterion.

    Parameters
    ----------
    series : (n,)
        Residual without offset and drift.
    most : int
        Highest order tried.
    rejected : (s,) of int or None
        Samples that do not count, 0 in the series: the autocovariance is that of the pairs without them.
    """
    most = min(most, max(series.size // 20, 0))
    if rejected is not None and rejected.size:
        n, covariance = autocovariance_among(series, most, rejected)
    else:
        n, covariance = series.size, autocovariance(series, most, float(series.mean()))
    if covariance[0] <= 0.0:
        return Autoregression(np.ones(1), 0.0)
    orders = [0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 40]
    models = [_yule_walker(covariance, order) for order in orders if order <= most]
    models = [model for model in models if model.sigma > 0.0] or models[:1]
    return min(models, key=lambda m: n * np.log(max(m.sigma, 1e-300) ** 2) + np.log(n) * m.order)


def autocovariance_among(series: FloatArray, lags: int, rejected: NDArray[np.int64]) -> tuple[int, FloatArray]:
    """Return how many samples count, and the autocovariance about their mean over the pairs of which both do.

    Biased like that of a whole series, so that it stays the covariance of something where few are missing.
    """
    counted = np.ones(series.size)
    counted[rejected] = 0.0
    n = int(counted.sum())
    mean = float(series @ counted) / max(n, 1)
    pairs = autocovariance(counted, lags)
    expected = 1.0 - np.arange(pairs.size) / series.size
    return n, autocovariance((series - mean) * counted, lags) * expected / np.maximum(pairs, 1e-300)


def _yule_walker(covariance: FloatArray, order: int) -> Autoregression:
    if order == 0:
        return Autoregression(np.ones(1), float(np.sqrt(covariance[0])))
    a = -solve_toeplitz(covariance[:order], covariance[1 : order + 1])
    variance = covariance[0] + a @ covariance[1 : order + 1]
    return Autoregression(np.concatenate([[1.0], a]), float(np.sqrt(max(variance, 0.0))))
