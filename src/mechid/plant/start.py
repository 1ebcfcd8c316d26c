"""Start values of records: initial states off the commanded rest, and their typical magnitudes.

Each is a symbol in the blocks' expressions of their initial states, zero unless a record has a value of its own.
"""

from __future__ import annotations

from sympy import Symbol, symbols

from mechid.parameter import Declaration

ANGLE, RATE, TWIST, TWIST_RATE = symbols("alpha_start omega_start_own twist_start twist_rate_start")
HOLDING_TORQUE = Symbol("T_hold")
"""Placeholder of the motor's holding torque in the magnitudes of start values."""
MOST = 1.5
"""Multiple of the magnitude, either way, within which a start value is searched."""
FULL_STEP = "pi/p"
"""Full step of the rotor, rad."""
OUTPUT_TORQUE = "T_hold*Abs(G)"
"""Torque at the output with the motor held by one phase, N m."""


def start(key: str, symbol: Symbol, unit: str, meaning: str, size: str | None = None) -> Declaration:
    """Return the declaration of a start value that a record may have of its own, zero otherwise.

    Parameters
    ----------
    key : str
        Name of the start value, e.g. ``"angle"``.
    symbol : Symbol
        Its symbol in the expressions of the initial states.
    unit, meaning : str
    size : str or None
        Typical magnitude, in the file's symbols and `T_hold`.
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
