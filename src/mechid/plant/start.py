"""The start of a record off the rest at the commanded angle: what may be a record's own, and how large it mostly is.

Each is a symbol in the blocks' expressions of their states at the start, zero where a record has none of its own.
"""

from __future__ import annotations

from sympy import Symbol, symbols

from mechid.parameter import Declaration

ANGLE, RATE, TWIST, TWIST_RATE = symbols("alpha_start omega_start_own twist_start twist_rate_start")
HOLDING_TORQUE = Symbol("T_hold")
"""Stands for the motor's holding torque in the sizes of starts."""
MOST = 1.5
"""Of its size, either way, within which a start is looked for."""
FULL_STEP = "pi/p"
"""Of the rotor, rad."""
OUTPUT_TORQUE = "T_hold*Abs(G)"
"""Of the motor held by one phase, at the output, N m."""


def start(key: str, symbol: Symbol, unit: str, meaning: str, size: str | None = None) -> Declaration:
    """Return the declaration of what a record may have of its own at its start, zero where it has none.

    Parameters
    ----------
    key : str
        What it is, e.g. ``"angle"``.
    symbol : Symbol
        In the expressions of the states at the start.
    unit, meaning : str
    size : str or None
        How large it mostly is, in the file's symbols and `T_hold`.
    """
    return Declaration(
        key=f"start.{key}",
        symbol=symbol.name,
        unit=unit,
        meaning=meaning,
        source="the record",
        default=0.0,
        typical=(size, -MOST, MOST) if size else None,
    )
