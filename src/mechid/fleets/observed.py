"""One parameter over a fleet: the values that count, of campaigns, and brought to one value of each unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.fleets.angles import unwrapped
from mechid.fleets.estimates import DEGREES, Estimate
from mechid.fleets.members import Member
from mechid.fleets.regression import regression


@dataclass(frozen=True, kw_only=True)
class Observed:
    """A parameter's values that count.

    Attributes
    ----------
    name, unit : str
        The unit is that of the file.
    members : tuple of Member
        Of the campaigns, n of them.
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
        """The units, in order of appearance."""
        return tuple(dict.fromkeys(m.unit for m in self.members))

    @property
    def is_of_unit(self) -> FloatArray:
        """1 where a campaign is of a unit, else 0; (n, number of units)."""
        return np.array([[float(m.unit == unit) for unit in self.units] for m in self.members])

    def of(self, members: Sequence[Member]) -> Observed:
        """Return the same of some campaigns only."""
        kept = [k for k, member in enumerate(self.members) if member in members]
        chosen = tuple(self.members[k] for k in kept)
        return replace(self, members=chosen, values=self.values[kept], errors=self.errors[kept])

    def with_values(self, values: FloatArray) -> Observed:
        """Return the same with other values."""
        return replace(self, values=values)


@dataclass(frozen=True, kw_only=True)
class OfUnits:
    """One value of each unit.

    Attributes
    ----------
    units : tuple of str
        n of them.
    values, errors : (n,)
        Means over a unit's campaigns, whose scatter beyond their errors counts in the error.
    repeatability : float
        That scatter: how far campaigns of one unit differ, as a standard deviation; NaN where no unit has several.
    """

    units: tuple[str, ...]
    values: FloatArray
    errors: FloatArray
    repeatability: float


def observed(name: str, members: Sequence[Member], estimates: Sequence[Estimate | None]) -> Observed:
    """Return what of a parameter counts; estimates in the order of the members, None where there is none."""
    kept = [
        (member, value)
        for member, estimate in zip(members, estimates, strict=True)
        if estimate is not None and (value := estimate.values.get(name)) is not None and value.counts
    ]
    values, errors = (np.array([getattr(v, key) for _, v in kept], dtype=np.float64) for key in ("value", "error"))
    unit = next((v.unit for e in estimates if e is not None and (v := e.values.get(name))), "1")
    if unit == DEGREES and values.size:
        values = unwrapped(values, errors)
    return Observed(name=name, unit=unit, members=tuple(m for m, _ in kept), values=values, errors=errors)


def of_units(o: Observed) -> OfUnits:
    """Return one value of each unit; the scatter among campaigns of one unit is taken to be the same in all units."""
    belongs, repeatability = o.is_of_unit, np.nan
    if len(o.units) < len(o.members):
        repeatability = regression(o.values, o.errors, belongs).scatter
    weights = 1.0 / (np.square(o.errors) + np.nan_to_num(repeatability) ** 2)
    total = belongs.T @ weights
    return OfUnits(
        units=o.units,
        values=belongs.T @ (weights * o.values) / total,
        errors=1.0 / np.sqrt(total),
        repeatability=float(repeatability),
    )
