"""Cautions about the findings of a fleet."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from mechid.fleets.fleet import Fleet
from mechid.fleets.trends import first_day, numbers
from mechid.fleets.verdict import list_names
from mechid.parameter import Status

FEW = 5
"""Units below which the spread is known to a factor of two or worse."""
TOGETHER = 0.8
"""Correlation of two covariates above which their trends cannot be separated."""


def cautions(fleet: Fleet) -> tuple[str, ...]:
    """Return the limitations of the findings, each as a sentence with its remedy."""
    return (*_file_cautions(fleet), *_error_cautions(fleet), *_sample_cautions(fleet))


def _file_cautions(fleet: Fleet) -> Iterator[str]:
    """Yield differences between mechanism files."""
    there = [(m.label, e) for m, e in zip(fleet.asked.members, fleet.estimates, strict=True) if e is not None]
    plants: dict[str, str] = {}
    for label, e in there:
        plants.setdefault(e.plant, label)
    if len(plants) > 1:
        yield (
            f"The mechanism files have {len(plants)} sets of equations, as those of "
            f"{list_names(list(plants.values()))}: a parameter of the same name stands "
            "beside other terms there, and may differ for that alone."
        )
    for p in fleet.parameters:
        known = {v.value for _, e in there if (v := e.values.get(p.name)) and v.status == Status.KNOWN}
        if len(known) > 1:
            yield (
                f"{p.name} is a known number in the mechanism files, and not the same in all: what depends on it may "
                "differ for that alone."
            )
        frozen = [label for label, e in there if (v := e.values.get(p.name)) and v.status == Status.FROZEN]
        if frozen and len(frozen) < len(there):
            held = list_names(frozen)
            yield f"{p.name} was held (frozen) in {held}, and is estimated in others; it is left out there."
    versions = sorted({e.version for _, e in there if e.version})
    if len(versions) > 1:
        yield (
            f"The estimates come from mechid {' and '.join(versions)}; remove the folders of the older ones to have "
            "them identified anew."
        )


def _error_cautions(fleet: Fleet) -> Iterator[str]:
    """Yield standard errors that are not reliable."""
    near = [
        m.label
        for m, e in zip(fleet.asked.members, fleet.estimates, strict=True)
        if e is not None and e.grade.good and any(v.counts and v.near_threshold for v in e.values.values())
    ]
    if near:
        yield (
            f"Near a stick/slip threshold, so that standard errors hold on one side of it only: {list_names(near)}. "
            "Mean and spread rest on the scatter of the units, and hold; that the units differ, and what has changed "
            "in one unit, rest on those errors."
        )


def _sample_cautions(fleet: Fleet) -> Iterator[str]:
    """Yield small numbers of units, and correlated covariates."""
    most = max((len(p.spread.unit_values.units) for p in fleet.parameters if p.spread), default=0)
    if 0 < most < FEW:
        yield f"{most} units: the spread is hardly known, as its interval says; units stand off from four units on."
    for a, b in combinations(fleet.asked.covariates, 2):
        members = [m for m in fleet.asked.members if a in m.covariates and b in m.covariates]
        x, y = (numbers([m.covariates[n] for m in members], first_day(members, n)) for n in (a, b))
        if len(members) > 2 and min(np.ptp(x), np.ptp(y)) > 0.0:
            together = float(np.corrcoef(x, y)[0, 1])
            if abs(together) > TOGETHER:
                yield (
                    f"{a} and {b} go together over the campaigns (correlation {together:.2f}): a trend over one may be "
                    "the other's."
                )
