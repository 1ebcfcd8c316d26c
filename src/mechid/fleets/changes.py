"""What has changed between two states of the same units, such as before and after vibration.

A unit's change is the difference of its two estimates, with both errors: they come from different records. What the
two share, such as a wrong supply voltage or what the model lacks at both times, cancels in the difference and not in
its error, which is on the safe side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from mechid.fleets.observed import Observed
from mechid.fleets.regression import common
from mechid.fleets.spread import LEAST
from mechid.units import angle_difference


@dataclass(frozen=True, kw_only=True)
class Change:
    """A parameter of one unit after, less before."""

    name: str
    unit: str
    states: tuple[str, str]
    difference: float
    error: float
    p_value: float


@dataclass(frozen=True, kw_only=True)
class MeanChange:
    """A parameter's change over all units that have both states: mean, its error and interval, spread over units."""

    name: str
    states: tuple[str, str]
    units: int
    mean: float
    error: float
    mean95: tuple[float, float]
    spread: float
    p_value: float


def changes(o: Observed, states: tuple[str, str]) -> tuple[Change, ...]:
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
        p = float(2.0 * ndtr(-abs(difference) / error))
        out.append(Change(name=o.name, unit=unit, states=states, difference=difference, error=error, p_value=p))
    return tuple(out)


def mean_change(each: tuple[Change, ...]) -> MeanChange | None:
    """Return the mean of some units' changes of one parameter; None of fewer than two."""
    if len(each) < LEAST:
        return None
    made = common(np.array([c.difference for c in each]), np.array([c.error for c in each]))
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
