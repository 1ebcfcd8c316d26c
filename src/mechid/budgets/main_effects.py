"""Main effects of independent Gaussian variables on a value, from three evaluations along each variable."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.shares import CURVATURE

STEP = float(np.sqrt(3.0))
"""Standard deviations to either side of the centre: abscissae of the three-point Gauss-Hermite rule, whose weights are
1/6, 2/3 and 1/6."""


@dataclass(frozen=True, eq=False)
class MainEffects:
    """Function values at the centre and at two points along each variable.

    Mean and variance are exact for a sum of functions of one variable each: cubic for the mean, quadratic for the
    variance. Interactions of variables are neglected.

    Parameters
    ----------
    centre : float
    above, below : (d,)
        At `STEP` standard deviations on both sides, one variable at a time.
    """

    centre: float
    above: FloatArray
    below: FloatArray

    @property
    def mean(self) -> float:
        """Mean over the variables."""
        return self.centre + float(np.sum(self._shifts))

    @property
    def sigma(self) -> float:
        """Standard deviation over the variables."""
        return float(np.sqrt(np.sum(self._variances)))

    @property
    def direction(self) -> FloatArray:
        """Unit vector (d,) of the steepest increase, the first axis for a constant function."""
        # The larger of both sides: a level that has its minimum at the centre still gets a direction.
        largest = np.maximum(np.abs(self.above - self.centre), np.abs(self.below - self.centre))
        along = np.where(self.above >= self.below, largest, -largest)
        size = float(np.linalg.norm(along))
        return np.asarray(along / size if size > 0.0 else np.eye(along.size)[0])

    def shares(self, names: Sequence[str]) -> Mapping[str, float]:
        """Return the linear share of each variable in the variance; the rest is `CURVATURE`."""
        lines = ((self.above - self.below) / (2.0 * STEP)) ** 2
        whole = float(np.sum(self._variances))
        if whole <= 0.0:
            return dict.fromkeys(names, 0.0)
        # Rounding may leave the rest of a linear function slightly negative.
        rest = max(1.0 - float(lines.sum()) / whole, 0.0)
        return {**dict(zip(names, (lines / whole).tolist(), strict=True)), CURVATURE: rest}

    @property
    def _shifts(self) -> FloatArray:
        return np.asarray((self.above + self.below - 2.0 * self.centre) / 6.0)

    @property
    def _variances(self) -> FloatArray:
        squares = ((self.above - self.centre) ** 2 + (self.below - self.centre) ** 2) / 6.0
        return np.asarray(squares - self._shifts**2)


def main_effects(function: Callable[[FloatArray], float], count: int) -> MainEffects:
    """Return the effects of independent variables, mean 0 and variance 1, on a function of them, (d,)."""
    steps = STEP * np.eye(count)
    above, below = (np.array([function(side * step) for step in steps]) for side in (1.0, -1.0))
    return MainEffects(function(np.zeros(count)), above, below)
