"""Powers of time in the units of a plant's parameters and outputs, with newton, metre and ampere as base units.

If a mechanism is described in seconds longer by a factor s, each value is multiplied by s to minus its power, while
torques, forces, angles and currents keep their values. A kilogram, N s2/m, has the power 2; a volt, N m/(s A), has the
power -1.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import sympy as sp

from mechid.arrays import FloatArray
from mechid.plant.plant import Plant
from mechid.units import SI_UNIT, time_power

COMMON = {
    **dict.fromkeys(
        ("1", "rad", "deg", "m", "N", "N m", "N*m", "N m/rad", "N/m", "N m/A", "V s/rad", "A", "H", "K", "1/K"), 0.0
    ),
    **dict.fromkeys(("rad/s", "m/s", "Hz", "V", "ohm"), -1.0),
    **dict.fromkeys(("s", "N m s/rad", "N s/m"), 1.0),
    **dict.fromkeys(("kg", "kg m2"), 2.0),
}
"""Powers of the units in mechid's own blocks; only other units are looked up in Pint, which is slow to load."""
SCALE = 2.0
"""Factor on time with which the power of a kernel parameter is read from its expression in the file's symbols."""


def unit_time_power(unit: str) -> float:
    """Return the power of time in a unit; 0 if the unit is unknown.

    Examples
    --------
    >>> unit_time_power("kg m2"), unit_time_power("rad/s"), unit_time_power("widgets")
    (2.0, -1.0, 0.0)
    """
    return COMMON[unit] if unit in COMMON else time_power(unit) or 0.0


@lru_cache(maxsize=32)
def time_powers(plant: Plant) -> FloatArray:
    """Return the power of time in each kernel parameter, (n_p,).

    A function of several values of the file, such as the cosine part of a detent, has the power of the whole
    expression.
    """
    declared = {sp.Symbol(d.symbol): unit_time_power(d.unit) for d in plant.declarations.values()}
    # Distinct values off any special point, at which no expression is zero by coincidence.
    some = dict(zip(declared, np.linspace(0.3, 0.9, len(declared)).tolist(), strict=True))
    scaled = {symbol: value * SCALE ** declared[symbol] for symbol, value in some.items()}
    powers = []
    for symbol, expression in plant.coordinates.items():
        if symbol == expression:
            powers.append(declared.get(symbol, 0.0))
        else:
            # Only its own symbols: SymPy takes a tenth of a second for the substitution of a hundred absent ones.
            own = expression.free_symbols
            before, after = (float(expression.subs({s: v for s, v in at.items() if s in own})) for at in (some, scaled))
            powers.append(float(np.log2(abs(after / before))))
    return np.array(powers)


def output_time_powers(plant: Plant) -> FloatArray:
    """Return the power of time in each output's unit, (n_y,)."""
    return np.array([unit_time_power(SI_UNIT.get(quantity, "1")) for quantity in plant.outputs])
