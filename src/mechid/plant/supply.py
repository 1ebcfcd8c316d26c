"""Source behind a voltage drive: its resistance makes the voltage of both phases drop with the current drawn.

A lossless bridge that switches at duty e_X draws e_X i_X from its source, since the power on both sides is equal
(Erickson and Maksimovic): u_X = (U - R_s i_s) e_X with i_s = e_A i_A + e_B i_B; V, A, ohm.
"""

from __future__ import annotations

from collections.abc import Mapping

from sympy import Expr, Float, Integer, Symbol, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Extension

TABLE = "supply"
ERICKSON = "Erickson, Maksimovic, Fundamentals of Power Electronics, 3rd ed. (2020), chapter 3: dc transformer model"
R_s, SAG = symbols("R_s U_sag")
DUTIES = {x: Symbol(f"duty_{x}_in") for x in "AB"}
RESISTANCE = Declaration(
    key=f"{TABLE}.resistance",
    symbol=R_s.name,
    unit="ohm",
    meaning="resistance of the source that feeds the driver",
    lower=0.0,
    supply_power=2,
    source=ERICKSON,
)
EXTENSION = Extension(
    name="supply.sag",
    words="the supply voltage falls with the current drawn",
    table=TABLE,
    widths={"resistance": Float(0.1) * Symbol("R")},
    grown=False,
)
"""A source with a tenth of the coils' resistance."""


def sag(currents: Mapping[str, Expr], share: Expr) -> Expr:
    """Return the voltage drop of the source, V, from the currents of both phases, A.

    `share` is the power of the motor over that of two phases with these currents, 3/2 for the axes of a star.
    """
    return share * R_s * sum((DUTIES[x] * i for x, i in currents.items()), Integer(0))


def settled_currents(alone: Mapping[str, Expr], resistances: Mapping[str, Expr], share: Expr) -> dict[str, Expr]:
    """Return the settled currents behind the source, from those on an ideal one.

    (R_X + R_s e_X^2) i_X + R_s e_X e_Y i_Y = U e_X + u_0X, solved for both (Sherman and Morrison).
    """
    through = {x: DUTIES[x] / R for x, R in resistances.items()}
    common = sag(alone, share) / (1 + sag(through, share))
    return {x: i - through[x] * common for x, i in alone.items()}
