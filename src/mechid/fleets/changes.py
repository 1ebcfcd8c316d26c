"""Changes between two states of the same units, such as before and after vibration.

A unit's change is the difference of its two estimates, with both errors: they come from different records. Errors
common to both, such as a wrong supply voltage or a model error at both times, cancel in the difference but
not in its standard error, which is therefore conservative.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from mechid.fleets.observations import Observations
from mechid.fleets.regression import random_effects_mean
from mechid.fleets.spread import LEAST
from mechid.units import angle_difference


@dataclass(frozen=True, kw_only=True)
class Change:
    """Difference of a parameter of one unit, after minus before."""

    name: str
    unit: str
    states: tuple[str, str]
    difference: float
    error: float
    p_value: float


@dataclass(frozen=True, kw_only=True)
class MeanChange:
    """Change of a parameter over all units with both states: mean, its error and interval, spread over units."""

    name: str
    states: tuple[str, str]
    units: int
    mean: float
    error: float
    mean95: tuple[float, float]
    spread: float
    p_value: float


def changes(o: Observations, states: tuple[str, str]) -> tuple[Change, ...]:
    """Return the change of each unit that has an estimate in both states."""
    at = {(m.unit, m.state): k for k, m in enumerate(o.members)}
    out = []
    for unit in o.units:
        before, after = (at.get((unit, state)) for state in states)
        if before is None or after is None:
            continue
        first, second = float(o.values[before]), float(o.values[after])
        difference = angle_difference(second, first) if o.is_angle else second - first
        error = float(np.hypot(o.errors[before], o.errors[after]))
        # The errors already have the width of Student's t (`Value.error`), so that the normal distribution applies.
        p = float(2.0 * ndtr(-abs(difference) / error))
        out.append(Change(name=o.name, unit=unit, states=states, difference=difference, error=error, p_value=p))
    return tuple(out)


def mean_change(each: tuple[Change, ...]) -> MeanChange | None:
    """Return the mean of the changes of one parameter over units; None for fewer than two."""
    if len(each) < LEAST:
        return None
    made = random_effects_mean(np.array([c.difference for c in each]), np.array([c.error for c in each]))
    return MeanChange(
        name=each[0].name,
        states=each[0].states,
        units=len(each),
        mean=float(made.coefficients[0]),
        error=made.error(),
        mean95=made.interval(),
        spread=made.scatter,
        p_value=made.p_value(),
    )
