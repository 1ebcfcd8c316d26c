"""Other force and moment components at a flight rate, interpolated between rates of the bench.

A line has a known phase at a bench rate, and between two bench rates that are close. It is interpolated linearly in the
complex plane; the interpolation error is zero at a bench rate and half the difference midway. Elsewhere, and where the
phase relative to the drive torque is unknown, the larger amplitude of both rates is used as a bound.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.analysis.settings import ORDER
from mechid.analysis.side_components import SideAtRate, SideLines, pooled, side_lines
from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.settings import RESIDUALS

COHERENT, MAGNITUDE, WITHIN = "coherent", "magnitude", "within noise"
"""Use of a line: with its phase relative to the drive torque; by its amplitude only; not at all, within the noise."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SideHere:
    """Lines of the components at one flight rate, along the bench's axes, about the mounting point.

    Attributes
    ----------
    components : tuple of str, (s,)
    lines : (K, s) complex
        At the orders of `TRACKED`, N or N m, phases relative to the drive torque's line; 0 for an unknown phase.
    bounds : (K, s)
        Amplitude of lines with an unknown phase.
    covariance : (K, s, s) complex
        Covariance of the lines' errors, E[e e^H].
    turn : (K,)
        Standard error of the phase common to all lines of an order, rad.
    outside : bool
        Whether the rate lies outside the measured range.
    far : bool
        Whether the neighbouring bench rates are too far away for a phase.
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

    def line_use(self, order: int, component: int) -> str:
        """Return the use of a line, by its positions among the orders and the components."""
        if self.lines[order, component]:
            return COHERENT
        return MAGNITUDE if self.bounds[order, component] else WITHIN

    def of(self, components: Sequence[str]) -> SideHere:
        """Return a subset of the components."""
        kept = [self.components.index(component) for component in components]
        return replace(
            self,
            components=tuple(components),
            lines=self.lines[:, kept],
            bounds=self.bounds[:, kept],
            covariance=self.covariance[:, kept][:, :, kept],
        )

    def without_phases(self) -> SideHere:
        """Return a copy with all phases unknown."""
        return replace(self, lines=np.zeros_like(self.lines), bounds=np.maximum(self.bounds, np.abs(self.lines)))


def pool_by_rate(cells: Sequence[SideAtRate]) -> list[SideAtRate]:
    """Pool the measurements of several records at each rate, ascending."""
    found: dict[int, list[SideAtRate]] = {}
    for cell in cells:
        found.setdefault(round(np.log(cell.rate) / np.log1p(ORDER.rate_step)), []).append(cell)
    return sorted((pooled(each) for each in found.values()), key=lambda cell: cell.rate)


def interpolate_at_rate(cells: Sequence[SideAtRate], components: tuple[str, ...], rate: float) -> SideHere:
    """Return the components at a rate from those of the bench, ascending and at least one."""
    rates = np.array([cell.rate for cell in cells])
    off = np.abs(np.log(rates / rate))
    above = int(np.searchsorted(rates, rate))
    beside = [k for k in (above - 1, above) if 0 <= k < rates.size]
    outside = not rates[0] / (1.0 + ORDER.rate_step) <= rate <= rates[-1] * (1.0 + ORDER.rate_step)
    if len(beside) == 2 and max(off[beside]) <= np.log1p(RESIDUALS.near):
        low, high = (side_lines(cells[k]) for k in beside)
        return _interpolate(components, low, high, float((rate - rates[beside[0]]) / np.ptp(rates[beside])))
    nearest = side_lines(cells[int(np.argmin(off))])
    if off.min() <= np.log1p(ORDER.rate_step):
        return _interpolate(components, nearest, nearest, 0.0)
    sides = [side_lines(cells[k]) for k in beside]
    here = _interpolate(components, sides[0], sides[-1], 0.5).without_phases()
    # Inertial forces grow with the rate squared; the covariance grows with its square.
    grown = max(rate / rates[-1], 1.0) ** 2
    return replace(
        here, bounds=here.bounds * grown, covariance=here.covariance * grown**2, outside=bool(outside), far=True
    )


def _interpolate(components: tuple[str, ...], low: SideLines, high: SideLines, share: float) -> SideHere:
    """Return the lines at a fraction of the way from one rate to another."""
    lines = (1.0 - share) * low.lines + share * high.lines
    ends = [end for end, weight in ((low, 1.0 - share), (high, share)) if weight > 0.0]
    known = np.all([end.known for end in ends], axis=0)
    apart = np.where(known, high.lines - low.lines, 0.0)
    # Zero at both ends and a quarter of the squared difference midway.
    off = share * (1.0 - share) * apart[:, :, None] * apart[:, None, :].conj()
    covariance = (1.0 - share) ** 2 * low.covariance + share**2 * high.covariance + off
    turn = np.hypot((1.0 - share) * _zero_unknown(low.turn), share * _zero_unknown(high.turn))
    sigma = np.sqrt(0.5 * np.diagonal(covariance, axis1=1, axis2=2).real)
    size = np.abs(lines)
    # A line that is not resolved above its own error has no usable phase.
    known &= np.hypot(sigma, turn[:, None] * size) * ORDER.resolved < size
    largest = np.max([end.amplitude for end in ends], axis=0)
    return SideHere(
        components=components,
        lines=np.where(known, lines, 0.0),
        bounds=np.where(known, 0.0, largest),
        covariance=covariance,
        turn=turn,
    )


def _zero_unknown(turn: FloatArray) -> FloatArray:
    """Return standard errors of phases with unknown ones, which are not used, set to zero."""
    return np.where(np.isfinite(turn), turn, 0.0)
