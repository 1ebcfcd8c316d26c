"""Tooth meshes of a gear train: the orders of their lines per turn of the rotor, from the numbers of teeth."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from sympy import Abs, Expr, Function, Integer, Symbol

from mechid.parameter import Declaration
from mechid.plant.block import Agreement, NamedOrder
from mechid.plant.drive_train import G

TABLE = "gear.mesh"
DRIVER, DRIVEN, TEETH = "driver_teeth", "driven_teeth", "teeth"
"""Keys of the two numbers of teeth; a mechanism file writes both as ``teeth = [driver, driven]``."""
BEFORE, BEHIND = "ratio_before", "ratio_behind"
HUNTING = "hunting"
"""Last word of the name of the line of two teeth that meet again."""
MOST_TEETH = 100_000.0
RANDALL = "Randall, J. Mech. Design 104 (1982) 259-267: tooth meshing, shaft and hunting tooth frequencies"
ROUNDED = 1e-5
"""Relative difference of two ratios that rounding in the file explains."""


class CommonDivisor(Function):
    """Greatest common divisor of two whole numbers, evaluated once both are numbers."""

    @classmethod
    def eval(cls, a: Expr, b: Expr) -> Expr | None:
        """Return the divisor of two numbers, None for symbols."""
        return Integer(math.gcd(round(float(a)), round(float(b)))) if a.is_number and b.is_number else None


@dataclass(frozen=True)
class Mesh:
    """One pair of wheels: its position in the list, from 0."""

    index: int

    @property
    def driving_teeth(self) -> Symbol:
        """Number of teeth of the driving wheel."""
        return Symbol(f"z_a{self.index + 1}")

    @property
    def driven_teeth(self) -> Symbol:
        """Number of teeth of the driven wheel."""
        return Symbol(f"z_b{self.index + 1}")

    @property
    def before(self) -> Symbol:
        """Turns of the shaft before per turn of the driving wheel."""
        return Symbol(f"i_a{self.index + 1}")

    @property
    def behind(self) -> Symbol:
        """Turns of the driven wheel per turn of the shaft behind."""
        return Symbol(f"i_b{self.index + 1}")

    @property
    def declarations(self) -> tuple[Declaration, ...]:
        """Numbers of teeth, and the ratios of the stages before and behind whose teeth are not stated."""
        place = f"{TABLE}.{self.index}"

        def teeth(key: str, symbol: Symbol, which: str) -> Declaration:
            return Declaration(
                f"{place}.{key}",
                symbol.name,
                "1",
                f"number of teeth of the {which} wheel",
                lower=1.0,
                upper=MOST_TEETH,
                structural=True,
                source=RANDALL,
            )

        def ratio(key: str, symbol: Symbol, which: str) -> Declaration:
            return Declaration(
                f"{place}.{key}",
                symbol.name,
                "1",
                f"ratio of the stage {which}",
                lower=1e-6,
                default=1.0,
                structural=True,
                source=RANDALL,
            )

        return (
            teeth(DRIVER, self.driving_teeth, "driving"),
            teeth(DRIVEN, self.driven_teeth, "driven"),
            ratio(BEFORE, self.before, "between the mesh before, or the rotor, and the driving wheel"),
            ratio(BEHIND, self.behind, "between the driven wheel and the mesh behind, or the output"),
        )

    def lines(self, driver_turns: Expr) -> Iterator[NamedOrder]:
        """Yield the lines of a mesh whose driving wheel turns so often per turn of the rotor."""
        number, teeth = self.index + 1, driver_turns * self.driving_teeth
        pair = "tooth mesh {number:g} ({a:g}:{b:g})"
        values = {"number": Integer(number), "a": self.driving_teeth, "b": self.driven_teeth}
        yield NamedOrder(f"mesh {number}", pair, teeth, values)
        yield NamedOrder(f"mesh {number} driver", f"driving wheel of {pair}", driver_turns, values)
        yield NamedOrder(f"mesh {number} driven", f"driven wheel of {pair}", teeth / self.driven_teeth, values)
        # The same two teeth meet again after the least common multiple of both numbers of teeth.
        hunting = driver_turns * CommonDivisor(self.driving_teeth, self.driven_teeth) / self.driven_teeth
        yield NamedOrder(f"mesh {number} {HUNTING}", f"same two teeth of {pair}", hunting, values)


def meshes(count: int) -> tuple[Mesh, ...]:
    """Return a number of meshes, in their order from the rotor to the output."""
    return tuple(map(Mesh, range(count)))


def mesh_lines(count: int, *, teeth_only: bool = False) -> tuple[NamedOrder, ...]:
    """Return the lines of a train of meshes, each of which follows the one before it, as orders per rotor turn."""
    turns, found = Integer(1), list[NamedOrder]()
    for mesh in meshes(count):
        turns = turns / mesh.before
        teeth, *others = mesh.lines(turns)
        found += [teeth] if teeth_only else [teeth, *others]
        turns = turns * mesh.driving_teeth / mesh.driven_teeth / mesh.behind
    return tuple(found)


def ratio_agreements(count: int) -> tuple[Agreement, ...]:
    """Return the condition that the stages of a train multiply to the ratio of the gear; none without meshes."""
    if not count:
        return ()
    product: Expr = Integer(1)
    for mesh in meshes(count):
        product = product * mesh.before * mesh.driven_teeth / mesh.driving_teeth * mesh.behind
    return (
        Agreement(
            name=TABLE,
            value=product,
            wanted=Abs(G),
            within=ROUNDED,
            words="the meshes and the stages between them give a ratio of {value:.9g}, gear.ratio is {wanted:.9g}; "
            f"correct the teeth, or write the stage that is missing as {BEHIND} = {{missing:.9g}} under the last "
            f"[[{TABLE}]], or as {BEFORE} under the first",
        ),
    )
