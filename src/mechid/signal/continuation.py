"""Continuation of a series beyond its end by linear prediction, for filters that need samples on both sides.

The coefficients are those of Burg's method, whose predictions never grow (Burg, Modern spectrum analysis, 1967; Kay,
Modern Spectral Estimation, 1988, 7.6).
"""

from __future__ import annotations

import numpy as np

from mechid.arrays import FloatArray

ORDER, TRAINED = 160, 4096
"""Coefficients, and samples at the end of a series that they come from."""


def burg_coefficients(y: FloatArray, order: int) -> FloatArray:
    """Return the coefficients a of the prediction error y_k + a_1 y_(k-1) + ... + a_n y_(k-n), (n + 1,), a_0 being 1.

    Parameters
    ----------
    y : ndarray, shape (N,)
        Without its mean.
    order : int
        n, below N.
    """
    coefficients = np.ones(1)
    forward, backward = y[1:].copy(), y[:-1].copy()
    for _ in range(order):
        power = forward @ forward + backward @ backward
        if not power > 0.0:
            break  # predicted exactly, as zeros are
        reflection = -2.0 * (backward @ forward) / power
        padded = np.append(coefficients, 0.0)
        coefficients = padded + reflection * padded[::-1]
        forward, backward = (forward + reflection * backward)[1:], (backward + reflection * forward)[:-1]
    return coefficients


def continue_series(y: FloatArray, count: int) -> FloatArray:
    """Return `count` samples that continue a series, (count,).

    Parameters
    ----------
    y : ndarray, shape (N,)
        Only its end counts.
    count : int

    Examples
    --------
    >>> time = np.arange(500)
    >>> bool(np.allclose(continue_series(np.cos(0.1 * time), 50), np.cos(0.1 * np.arange(500, 550)), atol=0.02))
    True
    """
    from scipy.signal import lfilter, lfiltic  # half a second to import

    end = y[-TRAINED:]
    mean = float(end.mean())
    a = burg_coefficients(end - mean, min(ORDER, end.size // 3))
    if a.size == 1:
        return np.full(count, mean)
    state = lfiltic([1.0], a, (end - mean)[::-1][: a.size - 1])
    return np.asarray(lfilter([1.0], a, np.zeros(count), zi=state)[0] + mean, dtype=np.float64)
