"""Errors of other sources than the mechanism: the user's bias, random and periodic entries of the budget."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mechid.budget.indices import Index
from mechid.budget.pointing_error import PointingError, Random, Source
from mechid.budget.summation import Contribution

FloatArray = NDArray[np.float64]

LEAST_POINTS, POINTS_A_LOBE = 2001, 40
"""Of a density over frequency: so many at least, and so many between the zeros of an index's weight."""


@dataclass(frozen=True, kw_only=True, eq=False)
class OtherError:
    """An error of another source along the lines of sight.

    Parameters
    ----------
    name : str
    kind : str
        "bias", "random" (size: standard deviation over time) or "periodic" (size: amplitude).
    axes : (m,) bool
        Lines of sight along which it acts.
    size_rad, spread_rad : float
        Mean and standard deviation of the size over the ensemble.
    frequency_hz : float
        Of a periodic one.
    bandwidth_hz : float
        Of a random one, whose density is flat up to it.
    group : str
        Errors of one group are fully correlated in the ECSS sum, and drawn together; empty: alone.
    """

    name: str
    kind: str
    axes: NDArray[np.bool_]
    size_rad: float
    spread_rad: float = 0.0
    frequency_hz: float = 0.0
    bandwidth_hz: float = 0.0
    group: str = ""

    def added(self, error: PointingError, draw: float, longest_s: float) -> PointingError:
        """Return an error with this one added.

        Parameters
        ----------
        error : PointingError
        draw : float
            Of the size, in standard deviations from its mean.
        longest_s : float
            Longest time in the index: the density is given finely enough for it.
        """
        size = np.where(self.axes, self.size_rad + draw * self.spread_rad, 0.0)
        if self.kind == "bias":
            return replace(error, bias=error.bias + size)
        if self.kind == "random":
            points = max(LEAST_POINTS, int(POINTS_A_LOBE * self.bandwidth_hz * longest_s))
            f = np.linspace(0.0, self.bandwidth_hz, points)
            flat = np.tile(size**2 / (points * f[1]), (points, 1))
            return replace(error, randoms=(*error.randoms, Random(f, flat)))
        line = Source(self.name, self.frequency_hz, np.array([1]), size[None, :].astype(np.complex128))
        return replace(error, parts=(*error.parts, line))

    def contribution(self, index: Index, axis: int) -> Contribution | None:
        """Return what the index keeps of it along an axis, for the ECSS sum; None where it does not act."""
        if not self.axes[axis] or (self.kind == "bias" and not index.keeps_bias):
            return None
        kept = 1.0
        if self.kind == "periodic":
            kept = float(np.sqrt(index.weight(np.array([self.frequency_hz]))[0]))
        if self.kind == "random":
            nothing = PointingError(np.zeros(self.axes.size))
            unit = replace(self, size_rad=1.0).added(nothing, 0.0, index.longest_s)
            kept = float(unit.sigma(index)[axis])
        return Contribution(
            name=self.name, kind=self.kind, size=kept * self.size_rad, spread=kept * self.spread_rad, group=self.group
        )
