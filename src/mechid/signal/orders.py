"""Order analysis: sines whose phase is a multiple of the travelled position rather than of time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mechid.arrays import ComplexArray, FloatArray


def order_amplitudes(y: FloatArray, position: FloatArray, orders: Sequence[float]) -> tuple[ComplexArray, FloatArray]:
    """Fit the sines of all orders and a constant jointly to each signal by least squares.

    Parameters
    ----------
    y : ndarray, shape (N, C)
        Signals as columns, in any unit.
    position : ndarray, shape (N,)
        Travelled cycles of order one.
    orders : sequence of float, (K,)
        Above 0. N exceeds 2 K + 1, and the travel is long enough to resolve the orders.

    Returns
    -------
    amplitudes : ndarray, shape (K, C), complex
        c in Re(c exp(2 pi i order position)), in the unit of `y`.
    error : ndarray, shape (C,)
        Standard error of an amplitude's real and imaginary part, for a white residual.
    """
    amplitudes, left = fit_orders(y, position, orders)
    variance = np.sum(left**2, axis=0) / (position.size - 1 - 2 * len(orders))
    return amplitudes, np.asarray(np.sqrt(2.0 * variance / position.size), dtype=np.float64)


def fit_orders(y: FloatArray, position: FloatArray, orders: Sequence[float]) -> tuple[ComplexArray, FloatArray]:
    """Return the amplitudes as in `order_amplitudes`, (K, C), and the residual, (N, C)."""
    # Normal equations: if the travel resolves the orders, they are conditioned almost like the identity, and take a
    # quarter of the time of a decomposition of the sines.
    turning = order_phasors(position, orders)
    rows = np.concatenate([np.ones((1, position.size)), turning.real, turning.imag])
    solution, *_ = np.linalg.lstsq(rows @ rows.T, rows @ y, rcond=None)
    count = len(orders)
    amplitudes = solution[1 : count + 1] - 1j * solution[count + 1 :]
    return np.asarray(amplitudes, dtype=np.complex128), np.asarray(y - rows.T @ solution, dtype=np.float64)


def order_phasors(position: FloatArray, orders: Sequence[float]) -> ComplexArray:
    """Return exp(2 pi i order position), (K, N)."""
    # Each order is the previous one times the phasor of their difference: most differences are equal, which saves
    # almost all exponentials.
    steps = np.diff(orders, prepend=0.0).tolist()
    turned = {step: np.exp(2j * np.pi * step * position) for step in set(steps)}
    turning = np.empty((len(steps), position.size), dtype=np.complex128)
    last = np.ones(position.size, dtype=np.complex128)
    for row, step in zip(turning, steps, strict=True):
        last = np.multiply(last, turned[step], out=row)
    return turning


def order_signal(amplitudes: ComplexArray, position: FloatArray, orders: Sequence[float]) -> FloatArray:
    """Return the sum of the sines at travelled positions, (N,), in the unit of their complex amplitudes, (K,)."""
    turning = np.exp(2j * np.pi * np.outer(position, orders))
    return np.asarray((turning @ amplitudes).real, dtype=np.float64)
