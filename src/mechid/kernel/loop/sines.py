"""Sines and cosines."""

from __future__ import annotations

import math

from mechid.kernel.loop.plant import FAST, INNER, njit


@njit(**INNER)
def sine_and_cosine(angle: float) -> tuple[float, float]:
    """Sine and cosine to 1e-16 for |angle| < 1e6: reduction by pi/2 in three parts, then series."""
    turns = math.floor(angle * 0.6366197723675814 + 0.5)
    r = ((angle - turns * 1.5707963267341256) - turns * 6.077100506303966e-11) - turns * 2.0222662487959506e-21
    q = r * r
    s = r + r * q * (
        -1.66666666666666324348e-01
        + q
        * (
            8.33333333332248946124e-03
            + q
            * (
                -1.98412698298579493134e-04
                + q * (2.75573137070700676789e-06 + q * (-2.50507602534068634195e-08 + q * 1.58969099521155010221e-10))
            )
        )
    )
    c = (
        1.0
        - 0.5 * q
        + q
        * q
        * (
            4.16666666666666019037e-02
            + q
            * (
                -1.38888888888741095749e-03
                + q
                * (
                    2.48015872894767294178e-05
                    + q
                    * (-2.75573143513906633035e-07 + q * (2.08757232129817482790e-09 + q * -1.13596475577881948265e-11))
                )
            )
        )
    )
    quadrant = int(turns) & 3
    if quadrant & 1:
        s, c = c, -s
    return (-s, -c) if quadrant & 2 else (s, c)


@njit(**INNER, fastmath=FAST, forceinline=True)
def turned(s: float, c: float, angle: float) -> tuple[float, float]:
    """Sine and cosine after a small turn, to 1e-15; a large one goes by `sine_and_cosine`."""
    if abs(angle) > 0.1:
        sine, cosine = sine_and_cosine(angle)
        return s * cosine + c * sine, c * cosine - s * sine
    q = angle * angle
    qq = q * q
    sine = (-1.0 / 6.0 + q * (1.0 / 120.0)) - qq * (1.0 / 5040.0)
    versine = (0.5 - q * (1.0 / 24.0)) + qq * (1.0 / 720.0 - q * (1.0 / 40320.0))
    by_s, by_c = s * angle, c * angle
    return ((s + by_c) + (by_c * q) * sine) - (s * q) * versine, ((c - by_s) - (by_s * q) * sine) - (c * q) * versine
