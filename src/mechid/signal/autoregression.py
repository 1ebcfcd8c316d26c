"""Autoregressive models of coloured residuals."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.signal.moments import total
from mechid.signal.remainder import Remainder
from mechid.signal.series import BLOCK, Series, mean_of, stretch_of
from mechid.signal.stored import pieces_of
from mechid.signal.trend import Line

LONG = 4096
"""Samples after which a response counts no more: differences of a few samples, for which it is used, are settled."""


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

    def whitened(self, rows: FloatArray, memory: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return e of rows of r, (..., m), and the filter's memory behind them, (..., n); at first that is zeros."""
        from scipy.signal import lfilter  # takes 0.4 s to load, which only those pay whose noise has a colour

        white, memory = lfilter(self.coefficients, [1.0], rows, zi=memory)
        return white, memory

    def coloured(self, rows: FloatArray, memory: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return r of rows of e, the inverse of `whitened`."""
        from scipy.signal import lfilter

        rows, memory = lfilter([1.0], self.coefficients, rows, zi=memory)
        return rows, memory

    def covariance(self, lags: int) -> FloatArray:
        """Return the autocovariance of r at lags 0 to `lags`, in sigma^2; slow parts count for `LONG` samples."""
        response, _ = self.coloured(np.eye(1, LONG)[0], np.zeros(self.order))
        return np.array([response[: LONG - k] @ response[k:] for k in range(lags + 1)])


def autocovariance(series: Series, lags: int, mean: float = 0.0) -> FloatArray:
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


def autocorrelation(series: Series, lags: int) -> FloatArray:
    """Return the autocorrelation at lags 0 to `lags`, (lags + 1,), mean removed; NaN of a constant series."""
    covariance = autocovariance(series, lags, mean_of(series))
    return np.asarray(covariance / covariance[0], dtype=np.float64)


def autocovariance_among(series: Series, lags: int, rejected: IntArray) -> tuple[int, FloatArray]:
    """Return how many samples count, and the autocovariance about their mean over the pairs of which both do.

    Biased like that of a whole series, so that it stays the covariance of something where few are missing.
    """
    n = series.size - rejected.size
    counted = Remainder(series, rejected=rejected)
    mean = mean_of(counted) * series.size / max(n, 1)
    found = autocovariance(Remainder(series, Line(mean), rejected=rejected), lags)
    expected = 1.0 - np.arange(found.size) / series.size
    pairs = np.array([_pairs(series.size, rejected, lag) for lag in range(found.size)]) / series.size
    return n, found * expected / np.maximum(pairs, 1e-300)


def _pairs(samples: int, rejected: IntArray, lag: int) -> int:
    """Return how many pairs of samples are `lag` apart and both count."""
    one = int(np.sum(rejected < samples - lag) + np.sum(rejected >= lag))
    return samples - lag - one + np.intersect1d(rejected, rejected + lag, assume_unique=True).size


def fit_autoregression(series: Series, most: int = 40, rejected: IntArray | None = None) -> Autoregression:
    """Return the model by Burg's method whose order, up to `most`, minimises the Bayesian criterion.

    Burg's recursion on the products of lagged samples (covariance lattice: Makhoul 1977), so the series is read once
    and never copied whole. Unlike Yule-Walker's, it is not blunted by a spectrum that spans many decades, and unlike
    least squares it is always stable.

    Parameters
    ----------
    series : Series of n samples
        Residual without offset and drift.
    most : int
        Highest order tried.
    rejected : (s,) of int or None
        Samples that do not count: the products are those within the stretches between them.

    References
    ----------
    J. Makhoul, Stable and Efficient Lattice Methods for Linear Prediction, IEEE Transactions on Acoustics, Speech, and
    Signal Processing 25 (1977), pp. 423-428, doi:10.1109/TASSP.1977.1162979.
    """
    most = min(most, max(series.size // 20, 0))
    stretches = [series]
    if rejected is not None and rejected.size:
        stretches = _between(series, rejected)
        most = min(most, int(np.median([x.size for x in stretches])) // 2) if stretches else 0
    mean = sum(map(total, stretches)) / max(sum(x.size for x in stretches), 1)
    stretches = [x for x in stretches if x.size > most]
    if not any(np.any(x[part] != mean) for x in stretches for part in pieces_of(x)):
        return Autoregression(np.ones(1), 0.0)
    n = sum(x.size - most for x in stretches)
    first, *others = (_lagged_products(x, most, mean) for x in stretches)
    models = _burg(sum(others, first), n)
    return min(models, key=lambda m: n * np.log(max(m.sigma, 1e-300) ** 2) + np.log(n) * m.order)


def _between(series: Series, rejected: IntArray) -> list[Series]:
    """Return the stretches between rejected samples, as views."""
    stops = np.append(rejected, series.size)
    starts = np.insert(rejected + 1, 0, 0)
    return [stretch_of(series, a, b) for a, b in zip(starts.tolist(), stops.tolist(), strict=True) if b > a]


def _lagged_products(x: Series, most: int, mean: float = 0.0) -> FloatArray:
    """Return phi_ij, the sum of x_(k-i) x_(k-j) about `mean`, k from `most` to the end, (most + 1, most + 1)."""
    n = x.size
    phi = np.zeros((most + 1, most + 1))
    for start in range(most, n, BLOCK):
        part = x[start - most : min(start + BLOCK, n)] - mean
        phi[0] += [part[most:] @ part[most - j : part.size - j] for j in range(most + 1)]
    phi[:, 0] = phi[0]
    head, tail = x[:most][::-1] - mean, x[n - most :][::-1] - mean
    for i in range(most):  # a lag more on both sides: one product enters at the beginning, one leaves at the end
        phi[i + 1, 1:] = phi[i, :-1] + head[i] * head - tail[i] * tail
    return phi


def _burg(phi: FloatArray, samples: int) -> Iterator[Autoregression]:
    """Yield the models of all orders; forward and backward errors of each are quadratic forms in phi."""
    a = np.ones(1)
    yield Autoregression(a, math.sqrt(phi[0, 0] / samples))
    for order in range(1, phi.shape[0]):
        behind = a[::-1]
        forward = float(a @ phi[:order, :order] @ a)
        backward = float(behind @ phi[1 : order + 1, 1 : order + 1] @ behind)
        both = float(a @ phi[:order, 1 : order + 1] @ behind)
        mean = 0.5 * (forward + backward)
        reflection = -both / mean if mean > 0.0 else 0.0
        a = np.append(a, 0.0) + reflection * np.append(0.0, behind)
        yield Autoregression(a, math.sqrt(max(mean * (1.0 - reflection**2), 0.0) / samples))
