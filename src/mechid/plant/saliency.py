"""Saliency: variation of the coils' inductance with the rotor's angle, as its teeth approach and leave a pole.

L(x) = L (1 + s cos 2x) over the electrical angle x = p/2 alpha of a phase. The flux linkage L(x) i adds a voltage
omega i dL/dalpha to the back-EMF, and a torque i^2/2 dL/dalpha to that of the magnet (Acarnley); H, A, N m.
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
    """Inductance of a coil and its derivative with respect to the rotor's angle, H and H/rad."""

    value: Expr
    slope: Expr

    @classmethod
    def over(cls, angle: Expr, mean: Expr, *, salient: bool) -> Inductance:
        """Return the inductance of a coil at its electrical angle, in rad."""
        if not salient:
            return cls(mean, Integer(0))
        # The slope is per radian of the rotor; the electrical angle is p/2 times that.
        return cls(mean * (1 + s * cos(2 * angle)), -p * mean * s * sin(2 * angle))

    def torque(self, current: Expr) -> Expr:
        """Return the torque on the rotor, N m."""
        return self.slope * current**2 / 2
