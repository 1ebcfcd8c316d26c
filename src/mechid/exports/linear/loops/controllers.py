"""Sampled controllers of the electronics: PI of a phase current, PID with a notch of a position.

    current:    u[k] = kp e[k] + q[k],  q[k] = q[k-1] + ki T e[k]
    derivative: d[k] = a d[k-1] + (1 - a) kd (e[k] - e[k-1])/T,  a = exp(-2 pi f_d T)
    notch:      (s^2 + 2 depth zeta w s + w^2)/(s^2 + 2 zeta w s + w^2), bilinear with the centre kept

The bilinear transformation with a kept frequency is that of G. F. Franklin, J. D. Powell, M. Workman, Digital Control
of Dynamic Systems, 3rd ed., 1998, section 6.3.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.signal import tf2ss

from mechid.arrays import FloatArray
from mechid.exports.linear.loops.loop_file import CurrentLoop, Notch, PositionLoop
from mechid.exports.linear.loops.sampled import Sampled, series
from mechid.exports.linear.state_space import Matrices


def current_controller(loop: CurrentLoop, sensed: str, driven: str) -> Sampled:
    """Return the PI controller of one phase, from the error of `sensed` to `driven`."""
    step = loop.ki * loop.timing.period_s
    return _single([[1.0]], [[step]], [[1.0]], [[loop.kp + step]], loop.timing.period_s, sensed, driven)


def parallel(first: Sampled, second: Sampled) -> Sampled:
    """Return two controllers side by side, without coupling."""
    A1, B1, C1, D1 = first.matrices.all
    A2, B2, C2, D2 = second.matrices.all
    both = Matrices(*(_diagonal(a, b) for a, b in ((A1, A2), (B1, B2), (C1, C2), (D1, D2))))
    return Sampled(both, first.period_s, (*first.inputs, *second.inputs), (*first.outputs, *second.outputs))


def position_controller(loop: PositionLoop, driven: str, notch: Notch | None, sign: float = 1.0) -> Sampled:
    """Return the PID controller with its notch, from the error of the sensor to `driven`.

    Parameters
    ----------
    loop : PositionLoop
    driven : str
    notch : Notch or None
        Notch with its frequency, instead of the loop's own.
    sign : float
        1 or -1: sense in which a positive drive turns the sensor.
    """
    T = loop.timing.period_s
    a = math.exp(-2.0 * math.pi * loop.derivative_hz * T) if loop.derivative_hz else 0.0
    step, steep = loop.ki * T, (1.0 - a) * loop.kd / T
    # States: the integral, and the earlier error and derivative in one, d[k] = steep e[k] + x[k].
    pid = _single(
        [[1.0, 0.0], [0.0, a]],
        [[step], [(a - 1.0) * steep]],
        [[sign, sign]],
        [[sign * (loop.kp + step + steep)]],
        T,
        loop.sensor,
        driven,
    )
    return pid if notch is None else series(notch_filter(notch, T, loop.sensor), pid)


def notch_filter(notch: Notch, period_s: float, name: str) -> Sampled:
    """Return the sampled notch; its gain at the centre is the depth exactly."""
    assert notch.frequency_hz is not None
    half = math.tan(math.pi * notch.frequency_hz * period_s)
    wide, deep = 2.0 * notch.damping * half, 2.0 * notch.depth * notch.damping * half
    square = half * half
    above = np.array([1.0 + deep + square, 2.0 * square - 2.0, 1.0 - deep + square])
    below = np.array([1.0 + wide + square, 2.0 * square - 2.0, 1.0 - wide + square])
    A, B, C, D = tf2ss(above / below[0], below / below[0])
    return Sampled(Matrices(A, B, C, D), period_s, (name,), (name,))


def _single(
    A: list[list[float]],
    B: list[list[float]],
    C: list[list[float]],
    D: list[list[float]],
    period_s: float,
    sensed: str,
    driven: str,
) -> Sampled:
    matrices = Matrices(*(np.array(matrix, dtype=np.float64) for matrix in (A, B, C, D)))
    return Sampled(matrices, period_s, (sensed,), (driven,))


def _diagonal(a: FloatArray, b: FloatArray) -> FloatArray:
    out = np.zeros((a.shape[0] + b.shape[0], a.shape[1] + b.shape[1]))
    out[: a.shape[0], : a.shape[1]], out[a.shape[0] :, a.shape[1] :] = a, b
    return out
