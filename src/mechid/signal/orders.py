"""Orders: sines whose phase is a multiple of a travelled position rather than of time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def order_amplitudes(y: FloatArray, position: FloatArray, orders: Sequence[float]) -> tuple[ComplexArray, float]:
    """Return the sines of all orders together that fit `y` best beside a constant.

    Parameters
    ----------
    y : ndarray, shape (N,)
        Samples in any unit.
    position : ndarray, shape (N,)
        Travelled cycles of order one.
    orders : sequence of float, (K,)
        Above 0; N is more than 2 K + 1, and the travel tells the orders apart.

    Returns
    -------
    amplitudes : ndarray, shape (K,), complex
        c in Re(c exp(2 pi i order position)), in the unit of `y`.
    error : float
        Standard error of an amplitude's real and imaginary part, as if what is left over were white.
    """
    angle = 2.0 * np.pi * np.outer(position, orders)
    columns = np.column_stack((np.ones(y.size), np.cos(angle), np.sin(angle)))
    solution, *_ = np.linalg.lstsq(columns, y, rcond=None)
    left = y - columns @ solution
    variance = float(left @ left) / (y.size - columns.shape[1])
    count = len(orders)
    amplitudes = solution[1 : count + 1] - 1j * solution[count + 1 :]
    return np.asarray(amplitudes, dtype=np.complex128), float(np.sqrt(2.0 * variance / y.size))
