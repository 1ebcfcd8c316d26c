"""Values of one parameter over a fleet, by campaign and averaged by unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.fleets.angles import unwrap_angles
from mechid.fleets.estimates import DEGREES, Estimate
from mechid.fleets.members import Member
from mechid.fleets.regression import regression


@dataclass(frozen=True, kw_only=True)
class Observations:
    """Counted values of a parameter.

    Attributes
    ----------
    name, unit : str
        The unit is that of the file.
    members : tuple of Member
        Campaigns, n of them.
    values, errors : (n,)
        Angles on one branch.
    """

    name: str
    unit: str
    members: tuple[Member, ...]
    values: FloatArray
    errors: FloatArray

    @property
    def is_angle(self) -> bool:
        """Whether values 360 apart are the same."""
        return self.unit == DEGREES

    @property
    def units(self) -> tuple[str, ...]:
        """Units, in order of appearance."""
        return tuple(dict.fromkeys(m.unit for m in self.members))

    @property
    def is_of_unit(self) -> FloatArray:
        """1 if a campaign belongs to a unit, else 0; (n, number of units)."""
        return np.array([[float(m.unit == unit) for unit in self.units] for m in self.members])

    def of(self, members: Sequence[Member]) -> Observations:
        """Return the observations of some campaigns only."""
        kept = [k for k, member in enumerate(self.members) if member in members]
        chosen = tuple(self.members[k] for k in kept)
        return replace(self, members=chosen, values=self.values[kept], errors=self.errors[kept])

    def with_values(self, values: FloatArray) -> Observations:
        """Return the observations with other values."""
        return replace(self, values=values)


@dataclass(frozen=True, kw_only=True)
class UnitValues:
    """One value per unit.

    Attributes
    ----------
    units : tuple of str
        n of them.
    values, errors : (n,)
        Means over a unit's campaigns; their scatter beyond the errors is included in the error.
    repeatability : float
        Standard deviation of that scatter between campaigns of one unit; NaN if no unit has several.
    """

    units: tuple[str, ...]
    values: FloatArray
    errors: FloatArray
    repeatability: float


def collect_observations(name: str, members: Sequence[Member], estimates: Sequence[Estimate | None]) -> Observations:
    """Return the counted values of a parameter; estimates in the order of the members, None for a missing one."""
    kept = [
        (member, value)
        for member, estimate in zip(members, estimates, strict=True)
        if estimate is not None and (value := estimate.values.get(name)) is not None and value.counts
    ]
    values, errors = (np.array([getattr(v, key) for _, v in kept], dtype=np.float64) for key in ("value", "error"))
    unit = next((v.unit for e in estimates if e is not None and (v := e.values.get(name))), "1")
    if unit == DEGREES and values.size:
        values = unwrap_angles(values, errors)
    return Observations(name=name, unit=unit, members=tuple(m for m, _ in kept), values=values, errors=errors)


def average_by_unit(o: Observations) -> UnitValues:
    """Return one value per unit; the scatter among campaigns of one unit is assumed equal in all units."""
    belongs, repeatability = o.is_of_unit, np.nan
    if len(o.units) < len(o.members):
        # Estimated from all units together: two or three campaigns of one unit say little about their scatter.
        repeatability = regression(o.values, o.errors, belongs).scatter
    # NaN where no unit has several campaigns: the errors alone weigh then.
    weights = 1.0 / (np.square(o.errors) + np.nan_to_num(repeatability) ** 2)
    total = belongs.T @ weights
    return UnitValues(
        units=o.units,
        values=belongs.T @ (weights * o.values) / total,
        errors=1.0 / np.sqrt(total),
        repeatability=float(repeatability),
    )
