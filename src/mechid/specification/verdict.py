"""Verdict on a requirement: pass, fail, not shown, not decidable."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from mechid.arrays import BoolArray
from mechid.specification.bounded_values import BoundedValues
from mechid.specification.requirement import Requirement


class Verdict(StrEnum):
    """Verdict on a requirement; the later one decides where records differ."""

    PASS = "pass"
    NOT_SHOWN = "not_shown"
    NOT_DECIDABLE = "not_decidable"
    FAIL = "fail"


RANK = {verdict: k for k, verdict in enumerate(Verdict)}


@dataclass(frozen=True, kw_only=True)
class Worst:
    """Value that decides a verdict.

    Attributes
    ----------
    record : str
    rate : float
        Full steps/s, NaN where it is not known.
    frequency_hz : float
    value, sigma, limit : float
        In the SI unit of the requirement; the limit with its margin subtracted.
    lower, upper : float
        Bounds of the value.
    background : float
    margin_db : float
        Limit over value in decibels; infinite of a value of 0.
    """

    record: str
    rate: float
    frequency_hz: float
    value: float
    sigma: float
    limit: float
    lower: float
    upper: float
    background: float
    margin_db: float


@dataclass(frozen=True, kw_only=True)
class Judged:
    """Verdict on one requirement at one stretch of a record, or at all of them."""

    verdict: Verdict
    worst: Worst | None = None


def judge(values: BoundedValues, requirement: Requirement, record: str, rate: float) -> Judged:
    """Return the verdict at one stretch and the frequency that decides it.

    A lower bound above the mask is a fail. An upper bound above it leaves the frequency open: not decidable where the
    background itself is above the mask, otherwise not shown.
    """
    if not values.value.size:
        return Judged(verdict=Verdict.NOT_DECIDABLE)
    fails = values.lower > values.limit
    is_open = (values.upper > values.limit) & ~fails
    hidden = is_open & (values.background > values.limit)
    for verdict, which in ((Verdict.FAIL, fails), (Verdict.NOT_DECIDABLE, hidden), (Verdict.NOT_SHOWN, is_open)):
        if np.any(which):
            return Judged(verdict=verdict, worst=_worst(values, which, requirement, record, rate))
    everything = np.ones(values.value.size, dtype=np.bool_)
    return Judged(verdict=Verdict.PASS, worst=_worst(values, everything, requirement, record, rate))


def _worst(values: BoundedValues, which: BoolArray, requirement: Requirement, record: str, rate: float) -> Worst:
    numbers = np.flatnonzero(which)
    by_value = values.value[numbers] / values.limit[numbers]
    by_bound = values.upper[numbers] / values.limit[numbers]
    # Where all bounds are met, the largest value is of interest; otherwise the bound that is not met.
    k = int(numbers[np.argmax(by_value if np.any(by_value > 0.0) and not np.any(by_bound > 1.0) else by_bound)])
    value, limit = float(values.value[k]), float(values.limit[k])
    return Worst(
        record=record,
        rate=rate,
        frequency_hz=float(values.frequency_hz[k]),
        value=value,
        sigma=float(values.sigma[k]),
        limit=limit,
        lower=float(values.lower[k]),
        upper=float(values.upper[k]),
        background=float(values.background[k]),
        margin_db=requirement.decibels * float(np.log10(limit / value)) if value > 0.0 else np.inf,
    )


def combine(judged: list[Judged]) -> Judged:
    """Return the verdict over all stretches: the gravest, at the least margin among those."""
    if not judged:
        return Judged(verdict=Verdict.NOT_DECIDABLE)
    gravest = max((one.verdict for one in judged), key=RANK.__getitem__)
    same = [one for one in judged if one.verdict is gravest]
    return min(same, key=lambda one: _order(one, gravest))


def _order(one: Judged, verdict: Verdict) -> float:
    """Return the number by which stretches of one verdict are sorted, the worst first."""
    if one.worst is None:
        return np.inf
    if verdict is Verdict.PASS and np.isfinite(one.worst.margin_db):
        return one.worst.margin_db
    # Without a value the margin is infinite; 1000 dB sorts these behind all finite margins.
    return 1e3 - one.worst.upper / one.worst.limit if verdict is Verdict.PASS else -one.worst.upper / one.worst.limit
