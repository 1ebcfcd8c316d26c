"""What weakens the findings of a fleet."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from mechid.fleets.fleet import Fleet
from mechid.fleets.trends import first_day, numbers
from mechid.fleets.verdict import listed
from mechid.parameter import Status

FEW = 5
"""Units below which the spread is known to a factor of two or worse."""
TOGETHER = 0.8
"""Correlation of two covariates from which on their trends are not told apart."""


def cautions(fleet: Fleet) -> tuple[str, ...]:
    """Return what weakens the findings, each as a sentence with its remedy."""
    return (*_of_files(fleet), *_of_errors(fleet), *_of_numbers(fleet))


def _of_files(fleet: Fleet) -> Iterator[str]:
    """Yield where mechanism files are not alike."""
    there = [(m.label, e) for m, e in zip(fleet.asked.members, fleet.estimates, strict=True) if e is not None]
    plants: dict[str, str] = {}
    for label, e in there:
        plants.setdefault(e.plant, label)
    if len(plants) > 1:
        yield (
            f"The mechanism files have {len(plants)} sets of equations, as those of {listed(list(plants.values()))}: a "
            "parameter of the same name stands beside other terms there, and may differ for that alone."
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
            yield f"{p.name} was held (frozen) in {listed(frozen)}, and is estimated in others; it is left out there."
    versions = sorted({e.version for _, e in there if e.version})
    if len(versions) > 1:
        yield (
            f"The estimates come from mechid {' and '.join(versions)}; remove the folders of the older ones to have "
            "them identified anew."
        )


def _of_errors(fleet: Fleet) -> Iterator[str]:
    """Yield where errors are not to be relied on."""
    near = [
        m.label
        for m, e in zip(fleet.asked.members, fleet.estimates, strict=True)
        if e is not None and e.grade.good and any(v.counts and v.near_threshold for v in e.values.values())
    ]
    if near:
        yield (
            f"Near a stick/slip threshold, so that standard errors hold on one side of it only: {listed(near)}. Mean "
            "and spread rest on the scatter of the units, and hold; that the units differ, and what has changed "
            "in one unit, rest on those errors."
        )


def _of_numbers(fleet: Fleet) -> Iterator[str]:
    """Yield where there are too few units, or covariates that go together."""
    most = max((len(p.spread.of_units.units) for p in fleet.parameters if p.spread), default=0)
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
