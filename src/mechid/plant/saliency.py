"""Saliency: the coils' inductance varies with the rotor's angle, since its teeth come nearer to a pole and go away.

L(x) = L (1 + s cos 2x) over the electrical angle x = p/2 alpha of a phase. Its flux linkage L(x) i gives a voltage
omega i dL/dalpha beside the back-EMF, and a torque i^2/2 dL/dalpha beside that of the magnet (Acarnley); H, A, N m.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Expr, Float, Integer, cos, sin, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Extension

TABLE = "stepper.saliency"
ACARNLEY = "Acarnley, Stepping Motors: a Guide to Theory and Practice, 4th ed. (2002), chapter 1: variable reluctance"
s, p = symbols("s_L p")
SHARE = Declaration(
    key=f"{TABLE}.share",
    symbol=s.name,
    unit="1",
    lower=-0.9,
    upper=0.9,
    source=ACARNLEY,
    meaning="amplitude of the inductance's course over the electrical angle, over its mean",
)
EXTENSION = Extension(
    name=TABLE,
    words="the coils' inductance varies with the rotor's angle",
    table=TABLE,
    widths={"share": Float(0.03)},
    grown=False,
)


@dataclass(frozen=True)
class Inductance:
    """Inductance of a coil, and its derivative to the rotor's angle, H and H/rad."""

    value: Expr
    slope: Expr

    @classmethod
    def over(cls, angle: Expr, mean: Expr, *, salient: bool) -> Inductance:
        """Return that of a coil at its electrical angle, in rad."""
        if not salient:
            return cls(mean, Integer(0))
        return cls(mean * (1 + s * cos(2 * angle)), -p * mean * s * sin(2 * angle))

    def torque(self, current: Expr) -> Expr:
        """Return the torque on the rotor, N m."""
        return self.slope * current**2 / 2
