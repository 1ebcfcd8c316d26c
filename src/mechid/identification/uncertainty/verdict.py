"""Verdict on each parameter at the end of a search: estimated, at a bound, invisible, or not known well enough."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.campaign import Campaign
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.uncertainty.settings import VERDICTS
from mechid.parameter import Parameter, Status

Reason = tuple[Status, str]

IN_NO_STAGE = "in no stage of the campaign file that was run"
FAILED = "the simulation fails here"
ON_BOUND = "the optimum lies on or beyond the bound of the mechanism file"
UNSEEN = "no record sees it; add a record that does, or give it as a known number"
LEFT_BY_SEARCH = f"its value is where the search left it; {UNSEEN}"


@dataclass(frozen=True)
class Verdict:
    """Verdict at a point: coordinates with an uncertainty, coordinates on a bound, and reasons for missing errors.

    `reasons` gives, by name, the status of each free parameter without an error and its explanation.
    """

    q: FloatArray
    counted: BoolArray
    on_bound: BoolArray
    reasons: dict[str, Reason]


def judge(
    campaign: Campaign,
    problem: Problem,
    q: FloatArray,
    windows: Windows,
    triangle: Triangle,
    dependent: Mapping[str, str],
) -> Verdict:
    """Judge a point; parameters that no record sees return to the file's values if that changes nothing.

    `dependent` maps a parameter that is held for a dependence to the reason.
    """
    on, lost = problem.coordinates.on_bound(q), not np.isfinite(triangle.norm)
    seen = seen_coordinates(problem, triangle)
    back = _reset_unseen(campaign, problem, q, ~seen)
    unchanged = not lost and _is_same_norm(problem.total_norm(back, windows), triangle.norm)
    unseen = FAILED if lost else UNSEEN if unchanged else LEFT_BY_SEARCH
    reasons: dict[str, Reason] = {}
    for j, name in enumerate(problem.coordinates.names):
        if on[j] and (seen[j] or not unchanged):
            reasons[name] = (Status.AT_BOUND, _lower_limit_reason(problem, name, q[j]) or ON_BOUND)
        elif not seen[j]:
            reasons[name] = (Status.FROZEN, unseen)
    # A detent is searched in cosine and sine: its phase has no coordinate name and shares the amplitude's verdict.
    partners = {c.partner: c.name for c in problem.space.coordinates if c.partner}
    reasons |= {phase: reasons[amplitude] for phase, amplitude in partners.items() if amplitude in reasons}
    held = _free_names(campaign) - {*problem.coordinates.names, *partners}
    reasons |= {name: (Status.FROZEN, dependent.get(name, IN_NO_STAGE)) for name in held}
    return Verdict(back if unchanged else q, seen & ~on, seen & on, reasons)


def _lower_limit_reason(problem: Problem, name: str, excess: float) -> str:
    """Describe a parameter that equals its lower limit, where another parameter is that limit; else empty.

    Example: static friction equals Coulomb friction.
    """
    plant = problem.space.mechanism.plant
    below = plant.related_parameters("above").get(name)
    if below is None or excess > VERDICTS.least_excess:
        return ""
    return f"{plant.declarations[name].meaning} is at its lower limit, the {plant.declarations[below].meaning}"


def seen_coordinates(problem: Problem, triangle: Triangle) -> BoolArray:
    """Return the coordinates, (n,), whose whole range changes the records noticeably."""
    effect = np.linalg.norm(triangle.jacobian, axis=0) * problem.coordinates.span
    return np.asarray(np.isfinite(effect) & (effect > VERDICTS.negligible_change), dtype=np.bool_)


def _is_same_norm(norm: float, other: float) -> bool:
    return abs(norm - other) <= 1e-9 * other


def _free_names(campaign: Campaign) -> set[str]:
    """Return the names of all parameters that the fit of a campaign may change."""
    own = {q.name for record in campaign.estimated for q in record.parameters if q.is_free}
    return own | {q.name for q in campaign.mechanism.free}


def _reset_unseen(campaign: Campaign, problem: Problem, q: FloatArray, unseen: BoolArray) -> FloatArray:
    """Return the point with its unseen coordinates set to the values of the file."""
    mechanism, size = campaign.mechanism, problem.space.size
    values = {name: mechanism.value(name) for name in mechanism.parameters}
    found = problem.space.values(q[:size])
    hidden = {c.name for c, is_unseen in zip(problem.space.coordinates, unseen, strict=False) if is_unseen}
    here = problem.space.from_values({**values, **{n: v for n, v in found.items() if n not in hidden}})
    own = {q.name: q.value for record in campaign.records for q in record.parameters}
    return np.where(unseen, np.concatenate([here, problem.coordinates.records_point(own)]), q)


REMEDY = "its value is where the search left it; add a record that shows it, or give it as a known number"


def describe_unknown(parameter: Parameter, value: float, std_error: float) -> str:
    """Explain why the records do not determine a parameter, with the remedy; empty where they do.

    The allowed range over the root of 12 is the standard deviation of a value anywhere in it. A standard error above
    that, or one that is not finite, adds nothing to the range.

    Examples
    --------
    >>> from mechid.campaign import catalogue_mechanism
    >>> viscous = catalogue_mechanism().parameters["friction.viscous"]
    >>> describe_unknown(viscous, 0.006, 0.001)
    ''
    >>> describe_unknown(viscous, 0.006, 5e15).partition(";")[0]
    'not known from these records: its standard error of 5e+15 exceeds what its range of 0 to 0.05 allows'
    """
    span = parameter.max - parameter.min
    least = span / math.sqrt(12.0) if math.isfinite(span) else VERDICTS.most_relative * abs(value) or math.inf
    if std_error <= least and math.isfinite(std_error):
        return ""
    if not math.isfinite(std_error):
        return f"not known from these records: nothing limits it; {REMEDY}"
    allowed = f"its range of {parameter.min:.6g} to {parameter.max:.6g} allows"
    over = f"what {allowed}" if math.isfinite(span) else f"{VERDICTS.most_relative:g} times its value"
    return f"not known from these records: its standard error of {std_error:.3g} exceeds {over}; {REMEDY}"
