"""Differences between the groups of a fleet, such as lots, in a parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import fdtrc

from mechid.fleets.members import Member
from mechid.fleets.observations import UnitValues
from mechid.fleets.regression import regression


@dataclass(frozen=True, kw_only=True)
class GroupMean:
    """Mean of a parameter over the units of a group, with its standard error."""

    group: str
    units: int
    mean: float
    error: float


@dataclass(frozen=True, kw_only=True)
class GroupDifference:
    """Means of a parameter over groups, with the p-value of their difference.

    The spread from unit to unit is assumed equal in all groups (`scatter`); the test is the F test of equal means with
    the error of the random-effects model.
    """

    name: str
    means: tuple[GroupMean, ...]
    scatter: float
    p_value: float


def group_difference(name: str, each: UnitValues, members: Sequence[Member]) -> GroupDifference | None:
    """Return the difference of groups; None for fewer than two groups, or without more units than groups."""
    of: Mapping[str, str] = {m.unit: m.group for m in members}
    kept = [k for k, unit in enumerate(each.units) if of[unit]]
    groups = list(dict.fromkeys(of[each.units[k]] for k in kept))
    # With one unit in each group nothing is left to estimate the spread from unit to unit.
    if len(groups) < 2 or len(kept) <= len(groups):
        return None
    design = np.array([[float(of[each.units[k]] == group) for group in groups] for k in kept])
    made = regression(each.values[kept], each.errors[kept], design)
    # Differences of all groups from the first one span all differences of means.
    contrast = np.column_stack([np.full(len(groups) - 1, -1.0), np.eye(len(groups) - 1)])
    off = contrast @ made.coefficients
    ratio = float(off @ np.linalg.solve(contrast @ made.covariance @ contrast.T, off)) / off.size
    return GroupDifference(
        name=name,
        means=tuple(
            GroupMean(group=g, units=int(design[:, k].sum()), mean=float(made.coefficients[k]), error=made.error(k))
            for k, g in enumerate(groups)
        ),
        scatter=made.scatter,
        p_value=float(fdtrc(off.size, made.dof, ratio)),
    )
