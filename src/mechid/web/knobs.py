"""Knobs of the page: parameters with their range, scale and steps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from mechid.campaign import Campaign
from mechid.campaign.campaign import is_of_start
from mechid.identification.output_error.space import SearchSpace
from mechid.parameter import Parameter, Status
from mechid.plant.mechanism import Mechanism

HALF_TURN_DEG = 180.0
PERCENT = 0.01
NOTCHES = 2000
"""Notches of a slider between its ends; an arrow key moves it by one."""
FINE_SIGMAS, FINE_NOTCHES = 0.1, 0.01
"""Fine step in standard errors of the last estimate, or in notches without an estimate."""


@dataclass(frozen=True, kw_only=True)
class Knob:
    """A parameter that can be changed on the page.

    Attributes
    ----------
    parameter : Parameter
        Parameter at the value of the file, with the ends of the knob as bounds.
    is_log : bool
        Whether search and knob use a logarithmic scale.
    is_bounded : bool
        Whether the file gives the bounds; otherwise mechid chooses a range around the value.
    """

    parameter: Parameter
    is_log: bool
    is_bounded: bool

    @property
    def name(self) -> str:
        """Dotted name of the parameter."""
        return self.parameter.name

    def place(self, value: float) -> float:
        """Return the position of a value between the ends, 0 to 1, on the scale of the knob."""
        low, high = self.parameter.min, self.parameter.max
        inside = min(max(value, low), high)
        if self.is_log:
            return math.log(inside / low) / math.log(high / low)
        return (inside - low) / (high - low)

    def clip(self, value: float) -> float:
        """Return the nearest value between the ends."""
        return min(max(value, self.parameter.min), self.parameter.max)

    def step(self, value: float) -> tuple[float, str]:
        """Return a small step at a value and its description: 1 %, 1 deg, or 1 % of the range."""
        if self.parameter.declaration.unit == "deg":
            return 1.0, "1 deg"
        if value != 0.0:
            return PERCENT * abs(value), "1 %"
        return PERCENT * (self.parameter.max - self.parameter.min), "1 % of its range"

    def fine_step(self, value: float, sigma: float | None) -> float:
        """Return the step of an arrow key with Shift at a value: a tenth of a standard error."""
        # A notch can be hundreds of standard errors if the records determine the parameter well.
        if sigma:
            return FINE_SIGMAS * sigma
        low, high = self.parameter.min, self.parameter.max
        notch = value * math.log(high / low) / NOTCHES if self.is_log else (high - low) / NOTCHES
        return FINE_NOTCHES * notch


def knobs(campaign: Campaign) -> dict[str, Knob]:
    """Return the knobs of a campaign by dotted name: non-structural mechanism parameters, and free ones of records.

    Initial states of records have no knobs: nobody sets them by hand.
    """
    own = [
        with_range(q) for q in campaign.mechanism.parameters.values() if not q.declaration.structural and not q.tied_to
    ]
    logarithms = _logarithms(campaign.mechanism.with_parameters({q.name: q for q in own}))
    offsets = [q for r in campaign.records for q in r.parameters if q.is_free and not is_of_start(q)]
    bounded = {q.name for q in campaign.free}
    return {
        q.name: Knob(parameter=q, is_log=q.name in logarithms, is_bounded=q.name in bounded) for q in (*own, *offsets)
    }


def _logarithms(mechanism: Mechanism) -> set[str]:
    return {c.name for c in SearchSpace(mechanism).coordinates if c.kind == "log"}


def with_range(q: Parameter) -> Parameter:
    """Return the parameter as free, with its bounds or else a range around its value."""
    if q.is_free:
        return q
    low, high = _range(q)
    return replace(q, status=Status.FREE, min=low, max=high)


def _range(q: Parameter) -> tuple[float, float]:
    d = q.declaration
    if d.unit == "deg":
        return max(q.value - HALF_TURN_DEG, d.lower), min(q.value + HALF_TURN_DEG, d.upper)
    # A factor about 0 spans no range.
    if q.value == 0.0:
        return (d.lower if math.isfinite(d.lower) else -1.0), (d.upper if math.isfinite(d.upper) else 1.0)
    ends = sorted((q.value / d.spread, q.value * d.spread))
    return max(ends[0], d.lower), min(ends[1], d.upper)


def mechanism_at(
    mechanism: Mechanism, values: Mapping[str, float], free: frozenset[str], turned: Mapping[str, Knob]
) -> Mechanism:
    """Return the mechanism at the values of the knobs, with exactly the parameters `free` to be fitted."""
    own = {name: q for name, q in mechanism.parameters.items() if name in turned}
    return mechanism.with_parameters(
        {name: set_parameter(q, values[name], turned[name], is_free=name in free) for name, q in own.items()}
    )


def set_parameter(q: Parameter, value: float, knob: Knob, *, is_free: bool) -> Parameter:
    """Return a parameter at a value, free within the ends of the knob or known."""
    moved = q.at_value(value)
    if not is_free:
        return replace(moved, status=Status.KNOWN)
    return replace(moved, status=Status.FREE, min=knob.parameter.min, max=knob.parameter.max)
