"""Orders: sines whose phase is a multiple of a travelled position rather than of time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mechid.arrays import ComplexArray, FloatArray


def order_amplitudes(y: FloatArray, position: FloatArray, orders: Sequence[float]) -> tuple[ComplexArray, FloatArray]:
    """Return the sines of all orders together that fit each signal best beside a constant.

    Parameters
    ----------
    y : ndarray, shape (N, C)
        Signals as columns, in any unit.
    position : ndarray, shape (N,)
        Travelled cycles of order one.
    orders : sequence of float, (K,)
        Above 0; N is more than 2 K + 1, and the travel tells the orders apart.

    Returns
    -------
    amplitudes : ndarray, shape (K, C), complex
        c in Re(c exp(2 pi i order position)), in the unit of `y`.
    error : ndarray, shape (C,)
        Standard error of an amplitude's real and imaginary part, as if what is left over were white.
    """
    amplitudes, left = orders_and_rest(y, position, orders)
    variance = np.sum(left**2, axis=0) / (position.size - 1 - 2 * len(orders))
    return amplitudes, np.asarray(np.sqrt(2.0 * variance / position.size), dtype=np.float64)


def orders_and_rest(y: FloatArray, position: FloatArray, orders: Sequence[float]) -> tuple[ComplexArray, FloatArray]:
    """Return the amplitudes of the same sines, (K, C), and what they and the constant leave, (N, C).

    They are solved from their products with one another: of a travel that tells the orders apart these are about as
    far from singular as the identity, and take a quarter of the time that a decomposition of the sines does.
    """
    turning = turns(position, orders)
    rows = np.concatenate([np.ones((1, position.size)), turning.real, turning.imag])
    solution, *_ = np.linalg.lstsq(rows @ rows.T, rows @ y, rcond=None)
    count = len(orders)
    amplitudes = solution[1 : count + 1] - 1j * solution[count + 1 :]
    return np.asarray(amplitudes, dtype=np.complex128), np.asarray(y - rows.T @ solution, dtype=np.float64)


def turns(position: FloatArray, orders: Sequence[float]) -> ComplexArray:
    """Return exp(2 pi i order position), (K, N): each order from the one before, as most distances are alike."""
    steps = np.diff(orders, prepend=0.0).tolist()
    turned = {step: np.exp(2j * np.pi * step * position) for step in set(steps)}
    turning = np.empty((len(steps), position.size), dtype=np.complex128)
    last = np.ones(position.size, dtype=np.complex128)
    for row, step in zip(turning, steps, strict=True):
        last = np.multiply(last, turned[step], out=row)
    return turning


def order_signal(amplitudes: ComplexArray, position: FloatArray, orders: Sequence[float]) -> FloatArray:
    """Return the sum of sines at travelled positions, (N,), in the unit of their amplitudes, (K,) as above."""
    turning = np.exp(2j * np.pi * np.outer(position, orders))
    return np.asarray((turning @ amplitudes).real, dtype=np.float64)
