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
from mechid.signal.stored_series import pieces_of
from mechid.signal.trend import Line

RESPONSE_SAMPLES = 4096
"""Length of the impulse response used for covariances; covariances at lags of a few samples have converged by then."""


@dataclass(frozen=True)
class Autoregression:
    """Autoregressive model r_k + a_1 r_(k-1) + ... + a_n r_(k-n) = e_k, e white with standard deviation `sigma`.

    `coefficients`, (n + 1,), include the leading one. A model of order 0 describes a white series.
    """

    coefficients: FloatArray
    sigma: float

    @property
    def order(self) -> int:
        """Order n of the model."""
        return self.coefficients.size - 1

    def whiten_rows(self, rows: FloatArray, memory: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return e for rows of r, (..., m), and the final filter state, (..., n); the initial state is zero."""
        # Imported here because scipy.signal takes 0.4 s to load and is needed for coloured noise only.
        from scipy.signal import lfilter

        white, memory = lfilter(self.coefficients, [1.0], rows, zi=memory)
        return white, memory

    def colour_rows(self, rows: FloatArray, memory: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return r for rows of e, and the final filter state; the inverse of `whiten_rows`."""
        from scipy.signal import lfilter

        rows, memory = lfilter([1.0], self.coefficients, rows, zi=memory)
        return rows, memory

    def covariance(self, lags: int) -> FloatArray:
        """Return the autocovariance of r at lags 0 to `lags`, (lags + 1,), in units of sigma^2.

        The impulse response is truncated to `RESPONSE_SAMPLES` samples.
        """
        response, _ = self.colour_rows(np.eye(1, RESPONSE_SAMPLES)[0], np.zeros(self.order))
        return np.array([response[: RESPONSE_SAMPLES - k] @ response[k:] for k in range(lags + 1)])


def autocovariance(series: Series, lags: int, mean: float = 0.0) -> FloatArray:
    """Return the biased autocovariance of a series about `mean`, at lags 0 to `lags` or to the longest possible lag."""
    n, most = series.size, min(lags, series.size - 1)
    total = np.zeros(most + 1)
    # Blocks overlap by the longest lag, so that a long series is never copied as a whole.
    for start in range(0, n, BLOCK):
        size = min(BLOCK, n - start)
        ahead = np.zeros(size + most)
        part = series[start : start + size + most]
        ahead[: part.size] = part - mean
        total += [ahead[:size] @ ahead[k : k + size] for k in range(most + 1)]
    return total / n


def autocorrelation(series: Series, lags: int) -> FloatArray:
    """Return the autocorrelation about the mean at lags 0 to `lags`, (lags + 1,); NaN for a constant series."""
    covariance = autocovariance(series, lags, mean_of(series))
    return np.asarray(covariance / covariance[0], dtype=np.float64)


def autocovariance_of_accepted(series: Series, lags: int, rejected: IntArray) -> tuple[int, FloatArray]:
    """Return the number of accepted samples, and their autocovariance about their mean over all accepted pairs.

    The estimate is biased like that of a complete series, so that it remains close to positive semidefinite if few
    samples are missing.
    """
    n = series.size - rejected.size
    counted = Remainder(series, rejected=rejected)
    mean = mean_of(counted) * series.size / max(n, 1)
    found = autocovariance(Remainder(series, Line(mean), rejected=rejected), lags)
    # The sum contains only accepted pairs: it is scaled to the number of pairs that a complete series would have.
    expected = 1.0 - np.arange(found.size) / series.size
    pairs = np.array([_pairs(series.size, rejected, lag) for lag in range(found.size)]) / series.size
    return n, found * expected / np.maximum(pairs, 1e-300)


def _pairs(samples: int, rejected: IntArray, lag: int) -> int:
    """Return the number of pairs of accepted samples at a lag."""
    one = int(np.sum(rejected < samples - lag) + np.sum(rejected >= lag))
    return samples - lag - one + np.intersect1d(rejected, rejected + lag, assume_unique=True).size


def fit_autoregression(series: Series, most: int = 40, rejected: IntArray | None = None) -> Autoregression:
    """Fit an autoregressive model by Burg's method, with the order that minimises the Bayesian information criterion.

    The recursion uses the products of lagged samples (covariance lattice, Makhoul 1977), so the series is read once
    and never copied as a whole. In contrast to the Yule-Walker method, it remains accurate for spectra that span many
    decades; in contrast to least squares, the model is always stable.

    Parameters
    ----------
    series : Series of n samples
        Residual without offset and drift.
    most : int
        Maximum order.
    rejected : (s,) of int or None
        Indices of samples to exclude; products are formed within the stretches between them.

    References
    ----------
    J. Makhoul, Stable and Efficient Lattice Methods for Linear Prediction, IEEE Transactions on Acoustics, Speech, and
    Signal Processing 25 (1977), pp. 423-428, doi:10.1109/TASSP.1977.1162979.
    """
    # At least 20 samples per coefficient, and stretches of at least twice the order, leave enough products.
    most = min(most, max(series.size // 20, 0))
    stretches = [series]
    if rejected is not None and rejected.size:
        stretches = _stretches_between(series, rejected)
        most = min(most, int(np.median([x.size for x in stretches])) // 2) if stretches else 0
    mean = sum(map(total, stretches)) / max(sum(x.size for x in stretches), 1)
    stretches = [x for x in stretches if x.size > most]
    if not any(np.any(x[part] != mean) for x in stretches for part in pieces_of(x)):
        return Autoregression(np.ones(1), 0.0)
    n = sum(x.size - most for x in stretches)
    first, *others = (_lagged_products(x, most, mean) for x in stretches)
    models = _burg(sum(others, first), n)
    return min(models, key=lambda m: n * np.log(max(m.sigma, 1e-300) ** 2) + np.log(n) * m.order)


def _stretches_between(series: Series, rejected: IntArray) -> list[Series]:
    """Return the stretches between rejected samples, as views."""
    stops = np.append(rejected, series.size)
    starts = np.insert(rejected + 1, 0, 0)
    return [stretch_of(series, a, b) for a, b in zip(starts.tolist(), stops.tolist(), strict=True) if b > a]


def _lagged_products(x: Series, most: int, mean: float = 0.0) -> FloatArray:
    """Return phi_ij, the sum over k >= `most` of x_(k-i) x_(k-j) about `mean`, (most + 1, most + 1)."""
    n = x.size
    phi = np.zeros((most + 1, most + 1))
    for start in range(most, n, BLOCK):
        part = x[start - most : min(start + BLOCK, n)] - mean
        phi[0] += [part[most:] @ part[most - j : part.size - j] for j in range(most + 1)]
    phi[:, 0] = phi[0]
    head, tail = x[:most][::-1] - mean, x[n - most :][::-1] - mean
    # Increasing both lags by one adds a product at the beginning and removes one at the end: no further sums over x.
    for i in range(most):
        phi[i + 1, 1:] = phi[i, :-1] + head[i] * head - tail[i] * tail
    return phi


def _burg(phi: FloatArray, samples: int) -> Iterator[Autoregression]:
    """Yield the models of all orders; their forward and backward errors are quadratic forms in phi."""
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
