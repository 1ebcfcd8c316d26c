"""Mean and spread of a parameter over the units of a fleet, and the units that stand off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.fleets.observed import OfUnits
from mechid.fleets.outliers import Standing, farthest
from mechid.fleets.regression import common, further95

LEAST = 2
"""Units of which there is a mean and a spread."""


@dataclass(frozen=True, kw_only=True)
class Spread:
    """A parameter over the units of a fleet, in the file's unit.

    Attributes
    ----------
    of_units : OfUnits
    mean, error : float
        Of the fleet, and its standard error.
    mean95 : (float, float)
    spread : float
        Standard deviation from unit to unit, the errors of the estimates taken out.
    spread95 : (float, float)
    next95 : (float, float)
        Where a further unit lies, of 20 such 19.
    equal_p : float
        Probability that the errors alone scatter the units as much.
    standings : tuple of Standing
        Units that may stand off, the farthest first.
    """

    of_units: OfUnits
    mean: float
    error: float
    mean95: tuple[float, float]
    spread: float
    spread95: tuple[float, float]
    next95: tuple[float, float]
    equal_p: float
    standings: tuple[Standing, ...]

    def off(self, value: float, error: float) -> float:
        """Return how far a value lies from the mean, in the spread and its error together."""
        return (value - self.mean) / float(np.hypot(self.spread, error))


def spread(units: OfUnits) -> Spread | None:
    """Return mean and spread of the units' values; None of fewer than two units."""
    if len(units.units) < LEAST:
        return None
    made = common(units.values, units.errors)
    return Spread(
        of_units=units,
        mean=float(made.coefficients[0]),
        error=made.error(),
        mean95=made.interval(),
        spread=made.scatter,
        spread95=made.scatter95,
        next95=further95(units.values, units.errors),
        equal_p=made.equal_p,
        standings=farthest(units.values, units.errors),
    )
