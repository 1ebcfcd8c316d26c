"""Sines and cosines after a turn, without a choice, so that all sets go the same way."""

from __future__ import annotations

from mechid.kernel.loop.plant import FAST, INNER, njit


@njit(**INNER, fastmath=FAST, forceinline=True)
def turned(s: float, c: float, angle: float) -> tuple[float, float]:
    """Sine and cosine after a turn of up to `FAR`, to 1e-15: the series of both."""
    q = angle * angle
    qq = q * q
    sine = angle * (
        (1.0 - q * (1.0 / 6.0))
        + qq
        * (
            (1.0 / 120.0 - q * (1.0 / 5040.0))
            + qq * ((1.0 / 362880.0 - q * (1.0 / 39916800.0)) + qq * (1.0 / 6227020800.0))
        )
    )
    versine = q * (
        (0.5 - q * (1.0 / 24.0))
        + qq * ((1.0 / 720.0 - q * (1.0 / 40320.0)) + qq * (1.0 / 3628800.0 - q * (1.0 / 479001600.0)))
    )
    return (s + c * sine) - s * versine, (c - s * sine) - c * versine
