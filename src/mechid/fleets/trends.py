"""Trends of a parameter over a covariate, such as temperature, cycles or date: a straight line over the campaigns.

If most campaigns belong to units that were measured several times, each unit has its own level and the line is common
to its campaigns, so that differences between units are not mistaken for a trend. Otherwise the line passes through one
value per unit. The scatter about the line beyond the errors is included in its error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime

import numpy as np

from mechid.arrays import FloatArray
from mechid.fleets.members import Covariate, Member
from mechid.fleets.observations import Observations, average_by_unit
from mechid.fleets.regression import Regression, regression

DAY_S = 86400.0


@dataclass(frozen=True, kw_only=True)
class Trend:
    """Linear trend of a parameter over a covariate.

    Attributes
    ----------
    name, covariate : str
    slope, error : float
        Parameter's unit per unit of the covariate; for dates per day.
    slope95 : (float, float)
    p_value : float
        Two-sided p-value of the slope.
    dof : int
    reference, level : float
        Mean of the covariate over the campaigns, in days from the first for a date; value of the parameter there.
    scatter : float
        Standard deviation about the line beyond the errors.
    campaigns, units : int
    within : bool
        Whether each unit has its own level.
    """

    name: str
    covariate: str
    slope: float
    error: float
    slope95: tuple[float, float]
    p_value: float
    dof: int
    reference: float
    level: float
    scatter: float
    campaigns: int
    units: int
    within: bool


def numbers(values: Sequence[Covariate], first: date | None) -> FloatArray:
    """Return covariates as numbers; dates as days from the first, a time of day without a zone as UTC."""
    return np.array([_days(v) - (_days(first) if first else 0.0) if isinstance(v, date) else v for v in values])


def first_day(members: Sequence[Member], covariate: str) -> date | None:
    """Return the earliest date of a covariate; None if it is a number."""
    days = [d for m in members if isinstance(d := m.covariates.get(covariate), date)]
    return min(days, key=_days, default=None)


def _days(day: date) -> float:
    """Return days since 1 January of year 1."""
    if not isinstance(day, datetime):
        return float(day.toordinal())
    whole = day.astimezone(UTC) if day.tzinfo else day
    begun = whole.replace(hour=0, minute=0, second=0, microsecond=0)
    return whole.toordinal() + (whole - begun).total_seconds() / DAY_S


def trend(o: Observations, covariate: str, first: date | None) -> Trend | None:
    """Return the line over a covariate; None if the campaigns with that covariate cannot determine one."""
    kept = o.of([m for m in o.members if covariate in m.covariates])
    if not kept.members:
        return None
    x = numbers([m.covariates[covariate] for m in kept.members], first)
    reference, belongs = float(x.mean()), kept.is_of_unit
    # A campaign counts for the comparison within units if its unit has at least two.
    within = 2 * int((belongs.sum(axis=0)[belongs.argmax(axis=1)] > 1).sum()) > x.size
    if within:
        # The covariate is centred, so that the levels are those at its mean.
        made = _line(kept.values, kept.errors, x - reference, belongs)
    else:
        each = average_by_unit(kept)
        of_each = belongs.T @ (x - reference) / belongs.sum(axis=0)
        made = _line(each.values, each.errors, of_each, np.ones((of_each.size, 1)))
    if made is None:
        return None
    return Trend(
        name=o.name,
        covariate=covariate,
        slope=float(made.coefficients[0]),
        error=made.error(),
        slope95=made.interval(),
        p_value=made.p_value(),
        dof=made.dof,
        reference=reference,
        level=float(made.coefficients[1:].mean()),
        scatter=made.scatter,
        campaigns=x.size,
        units=belongs.shape[1],
        within=within,
    )


def _line(values: FloatArray, errors: FloatArray, x: FloatArray, levels: FloatArray) -> Regression | None:
    """Return slope and levels; None without degrees of freedom, or if the covariate does not vary."""
    left = x - levels @ np.linalg.lstsq(levels, x, rcond=None)[0]
    # A covariate that is constant within every level cannot be separated from the levels.
    if values.size <= levels.shape[1] + 1 or np.abs(left).max() <= 1e-9 * max(np.abs(x).max(), 1e-300):
        return None
    return regression(values, errors, np.column_stack([x, levels]))


def remove_trend(o: Observations, found: Trend, first: date | None) -> Observations:
    """Move a parameter along its line to the covariate's mean; campaigns without the covariate are unchanged."""
    off = [
        float(numbers([m.covariates[found.covariate]], first)[0]) - found.reference
        if found.covariate in m.covariates
        else 0.0
        for m in o.members
    ]
    return o.with_values(o.values - found.slope * np.array(off))
