"""Entries of harmonic lists in the mechanism file: order, amplitude and phase of a wave over an angle."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from sympy import Expr, S, Symbol, cos, pi, sin

from mechid.parameter import Declaration
from mechid.plant.block import PolarPair


@dataclass(frozen=True, kw_only=True)
class ListedHarmonic:
    """A sin(k x + phi) over an angle x, which the kernel represents as c sin(k x) + s cos(k x).

    Parameters
    ----------
    table : str
        List of the mechanism file, e.g. ``"gear.kinematic_error"``.
    index : int
        Position in the list, from 0.
    order : int or None
        k if it shapes the equations; None: the kernel takes it as a value, so that one kernel serves any k.
    letters : (str, str, str, str, str)
        Symbols of order, amplitude, phase, c and s; the position, from 1, is appended to each.
    unit : str
        Unit of the amplitude.
    most : float
        Largest amplitude.
    least, highest : float
        Smallest and largest order.
    meanings : (str, str, str)
        Meanings of order, amplitude and phase.
    source : str
    turns : Expr
        Periods of x per turn of the rotor, in the file's symbols.
    of_phase : bool
        As in `PolarPair`.
    """

    table: str
    index: int
    order: int | None
    letters: tuple[str, str, str, str, str]
    unit: str
    most: float = math.inf
    least: float = 1.0
    highest: float = math.inf
    meanings: tuple[str, str, str]
    source: str
    turns: Expr = S.One
    of_phase: bool = False

    @property
    def _symbols(self) -> tuple[Symbol, ...]:
        return tuple(Symbol(f"{letter}{self.index + 1}") for letter in self.letters)

    @property
    def parts(self) -> tuple[Symbol, Symbol]:
        """The kernel's c and s, whose waves are sin(k x) and cos(k x)."""
        *_, c, s = self._symbols
        return c, s

    def over(self, angle: Expr) -> Expr:
        """Return the wave over an angle in rad."""
        c, s = self.parts
        turned = self._symbols[0] * angle if self.order is None else self.order * angle
        return c * sin(turned) + s * cos(turned)

    @property
    def declarations(self) -> tuple[Declaration, ...]:
        """Order, amplitude and phase as declared for the file."""
        place, (order, amplitude, phase, *_) = f"{self.table}.{self.index}", self._symbols
        meanings = self.meanings
        return (
            Declaration(
                key=f"{place}.order",
                symbol=order.name,
                unit="1",
                meaning=meanings[0],
                lower=self.least,
                upper=self.highest,
                structural=True,
                source=self.source,
            ),
            Declaration(
                key=f"{place}.amplitude",
                symbol=amplitude.name,
                unit=self.unit,
                meaning=meanings[1],
                lower=0.0,
                upper=self.most,
                source=self.source,
            ),
            Declaration(f"{place}.phase_deg", phase.name, "deg", meanings[2], default=0.0, source=self.source),
        )

    @property
    def coordinates(self) -> dict[Symbol, Expr]:
        """The kernel's c and s as functions of the file's symbols."""
        _, amplitude, phase, c, s = self._symbols
        turned = phase * pi / 180
        return {c: amplitude * cos(turned), s: amplitude * sin(turned)}

    @property
    def polar(self) -> PolarPair:
        """Amplitude and phase as a pair."""
        place, order = f"{self.table}.{self.index}", self._symbols[0]
        c, s = self.parts
        return PolarPair(
            amplitude=f"{place}.amplitude",
            phase=f"{place}.phase_deg",
            cosine=c,
            sine=s,
            cycles=order * self.turns,
            of_phase=self.of_phase,
        )


def coordinates_of(harmonics: Iterable[ListedHarmonic]) -> dict[Symbol, Expr]:
    """Return the kernel's parameters of harmonics as functions of the file's symbols."""
    return {symbol: value for harmonic in harmonics for symbol, value in harmonic.coordinates.items()}
