"""How a parameter goes with a covariate, such as temperature, cycles or date: a straight line over the campaigns.

Where most campaigns are of units that were measured several times, each unit has its own level and the line is what
its campaigns have in common, so that differences from unit to unit are not taken for a trend. Else it is the line
through one value of each unit. The scatter about it beyond the errors counts in its error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime

import numpy as np

from mechid.arrays import FloatArray
from mechid.fleets.members import Covariate, Member
from mechid.fleets.observed import Observed, of_units
from mechid.fleets.regression import Regression, regression

DAY_S = 86400.0


@dataclass(frozen=True, kw_only=True)
class Trend:
    """The line of a parameter over a covariate.

    Attributes
    ----------
    name, covariate : str
    slope, error : float
        Parameter's unit for each of the covariate; of dates for each day.
    slope95 : (float, float)
    p_value : float
        Of a slope that large by chance.
    dof : int
    reference, level : float
        Mean of the covariate over the campaigns, in days from the first where it is a date; the parameter there.
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
    """Return the earliest date of a covariate; None where it is a number."""
    days = [d for m in members if isinstance(d := m.covariates.get(covariate), date)]
    return min(days, key=_days, default=None)


def _days(day: date) -> float:
    """Return days since the first of January of the year 1."""
    if not isinstance(day, datetime):
        return float(day.toordinal())
    whole = day.astimezone(UTC) if day.tzinfo else day
    begun = whole.replace(hour=0, minute=0, second=0, microsecond=0)
    return whole.toordinal() + (whole - begun).total_seconds() / DAY_S


def trend(o: Observed, covariate: str, first: date | None) -> Trend | None:
    """Return the line over a covariate; None where the campaigns that have it cannot give one."""
    kept = o.of([m for m in o.members if covariate in m.covariates])
    if not kept.members:
        return None
    x = numbers([m.covariates[covariate] for m in kept.members], first)
    reference, belongs = float(x.mean()), kept.is_of_unit
    within = 2 * int((belongs.sum(axis=0)[belongs.argmax(axis=1)] > 1).sum()) > x.size
    if within:
        made = _line(kept.values, kept.errors, x - reference, belongs)
    else:
        each = of_units(kept)
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
    """Return slope and levels; None where nothing is left over, or the covariate does not change."""
    left = x - levels @ np.linalg.lstsq(levels, x, rcond=None)[0]
    if values.size <= levels.shape[1] + 1 or np.abs(left).max() <= 1e-9 * max(np.abs(x).max(), 1e-300):
        return None
    return regression(values, errors, np.column_stack([x, levels]))


def without(o: Observed, found: Trend, first: date | None) -> Observed:
    """Return a parameter brought along its line to the covariate's mean; campaigns without it stay as they are."""
    off = [
        float(numbers([m.covariates[found.covariate]], first)[0]) - found.reference
        if found.covariate in m.covariates
        else 0.0
        for m in o.members
    ]
    return o.with_values(o.values - found.slope * np.array(off))
