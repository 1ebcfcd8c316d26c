"""The forces and moments beside the drive torque at a rate that flies, from those at the rates of the bench.

A line is known with its phase at a rate of the bench, and between two that are near. It runs straight from one to the
other in the complex plane, and may be off by what they differ by: nothing at a rate of the bench, half of it midway.
Elsewhere, and where a phase to the drive torque is not known, its amplitude alone counts, the larger of both rates': a
bound.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.analysis.settings import ORDER
from mechid.analysis.side_components import SideAtRate, SideLines, pool_measurements, side_lines
from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.settings import RESIDUALS

COHERENT, MAGNITUDE, WITHIN = "coherent", "magnitude", "within noise"
"""How a line counts: with its phase to the drive torque; by its amplitude alone; not, since noise explains it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SideHere:
    """Lines of the components at one rate that flies, along the bench's axes, about the mounting point.

    Attributes
    ----------
    components : tuple of str, (s,)
    lines : (K, s) complex
        At the orders of `TRACKED`, N or N m, phases to the drive torque's line; 0 where that phase is not known.
    bounds : (K, s)
        Amplitude of those whose phase is not known.
    covariance : (K, s, s) complex
        Of the lines' errors, E[e e^H].
    turn : (K,)
        Standard error of the phase that all lines of an order have in common, rad.
    outside : bool
        Whether the rate lies outside those measured.
    far : bool
        Whether the rates of the bench beside it are too far off for a phase.
    """

    components: tuple[str, ...]
    lines: ComplexArray
    bounds: FloatArray
    covariance: ComplexArray
    turn: FloatArray
    outside: bool = False
    far: bool = False

    @property
    def sigma(self) -> FloatArray:
        """Standard error of an amplitude, (K, s)."""
        return np.asarray(np.sqrt(0.5 * np.diagonal(self.covariance, axis1=1, axis2=2).real))

    def how(self, order: int, component: int) -> str:
        """Return how a line counts, by its places among the orders and the components."""
        if self.lines[order, component]:
            return COHERENT
        return MAGNITUDE if self.bounds[order, component] else WITHIN

    def of(self, components: Sequence[str]) -> SideHere:
        """Return some of the components."""
        kept = [self.components.index(component) for component in components]
        return replace(
            self,
            components=tuple(components),
            lines=self.lines[:, kept],
            bounds=self.bounds[:, kept],
            covariance=self.covariance[:, kept][:, :, kept],
        )

    def without_phases(self) -> SideHere:
        """Return the same with no phase known."""
        return replace(self, lines=np.zeros_like(self.lines), bounds=np.maximum(self.bounds, np.abs(self.lines)))


def by_rate(cells: Sequence[SideAtRate]) -> list[SideAtRate]:
    """Return measurements of several records as one at each rate, ascending."""
    found: dict[int, list[SideAtRate]] = {}
    for cell in cells:
        found.setdefault(round(np.log(cell.rate) / np.log1p(ORDER.rate_step)), []).append(cell)
    return sorted((pool_measurements(each) for each in found.values()), key=lambda cell: cell.rate)


def at_rate(cells: Sequence[SideAtRate], components: tuple[str, ...], rate: float) -> SideHere:
    """Return the components at a rate, from those of the bench, ascending and at least one."""
    rates = np.array([cell.rate for cell in cells])
    off = np.abs(np.log(rates / rate))
    above = int(np.searchsorted(rates, rate))
    beside = [k for k in (above - 1, above) if 0 <= k < rates.size]
    outside = not rates[0] / (1.0 + ORDER.rate_step) <= rate <= rates[-1] * (1.0 + ORDER.rate_step)
    if len(beside) == 2 and max(off[beside]) <= np.log1p(RESIDUALS.near):
        low, high = (side_lines(cells[k]) for k in beside)
        return _between(components, low, high, float((rate - rates[beside[0]]) / np.ptp(rates[beside])))
    nearest = side_lines(cells[int(np.argmin(off))])
    if off.min() <= np.log1p(ORDER.rate_step):
        return _between(components, nearest, nearest, 0.0)
    sides = [side_lines(cells[k]) for k in beside]
    here = _between(components, sides[0], sides[-1], 0.5).without_phases()
    grown = max(rate / rates[-1], 1.0) ** 2
    return replace(
        here, bounds=here.bounds * grown, covariance=here.covariance * grown**2, outside=bool(outside), far=True
    )


def _between(components: tuple[str, ...], low: SideLines, high: SideLines, share: float) -> SideHere:
    """Return the lines at a share of the way from one rate to another."""
    lines = (1.0 - share) * low.lines + share * high.lines
    ends = [end for end, weight in ((low, 1.0 - share), (high, share)) if weight > 0.0]
    known = np.all([end.known for end in ends], axis=0)
    apart = np.where(known, high.lines - low.lines, 0.0)
    off = share * (1.0 - share) * apart[:, :, None] * apart[:, None, :].conj()
    covariance = (1.0 - share) ** 2 * low.covariance + share**2 * high.covariance + off
    turn = np.hypot((1.0 - share) * _finite(low.turn), share * _finite(high.turn))
    sigma = np.sqrt(0.5 * np.diagonal(covariance, axis1=1, axis2=2).real)
    size = np.abs(lines)
    known &= np.hypot(sigma, turn[:, None] * size) * ORDER.resolved < size
    largest = np.max([end.amplitude for end in ends], axis=0)
    return SideHere(
        components=components,
        lines=np.where(known, lines, 0.0),
        bounds=np.where(known, 0.0, largest),
        covariance=covariance,
        turn=turn,
    )


def _finite(turn: FloatArray) -> FloatArray:
    """Return standard errors of phases, those of none as none: they are not used."""
    return np.where(np.isfinite(turn), turn, 0.0)
