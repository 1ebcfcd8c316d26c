"""Mean and spread of a parameter over the units of a fleet, and its candidate outliers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.fleets.observations import UnitValues
from mechid.fleets.outliers import Standing, farthest
from mechid.fleets.regression import prediction_interval95, random_effects_mean

LEAST = 2
"""Least number of units for a mean and a spread."""


@dataclass(frozen=True, kw_only=True)
class Spread:
    """Distribution of a parameter over the units of a fleet, in the file's unit.

    Attributes
    ----------
    unit_values : UnitValues
    mean, error : float
        Mean of the fleet, and its standard error.
    mean95 : (float, float)
    spread : float
        Standard deviation from unit to unit, without the errors of the estimates.
    spread95 : (float, float)
    next95 : (float, float)
        95 % prediction interval of a further unit.
    equal_p : float
        Probability of at least this scatter from the errors alone.
    standings : tuple of Standing
        Candidate outliers, the farthest first.
    """

    unit_values: UnitValues
    mean: float
    error: float
    mean95: tuple[float, float]
    spread: float
    spread95: tuple[float, float]
    next95: tuple[float, float]
    equal_p: float
    standings: tuple[Standing, ...]

    def standardized_distance(self, value: float, error: float) -> float:
        """Return the distance of a value from the mean, in units of spread and error together."""
        return (value - self.mean) / float(np.hypot(self.spread, error))


def spread(units: UnitValues) -> Spread | None:
    """Return mean and spread of the units' values; None for fewer than two units."""
    if len(units.units) < LEAST:
        return None
    made = random_effects_mean(units.values, units.errors)
    return Spread(
        unit_values=units,
        mean=float(made.coefficients[0]),
        error=made.error(),
        mean95=made.interval(),
        spread=made.scatter,
        spread95=made.scatter95,
        next95=prediction_interval95(units.values, units.errors),
        equal_p=made.equal_p,
        standings=farthest(units.values, units.errors),
    )
