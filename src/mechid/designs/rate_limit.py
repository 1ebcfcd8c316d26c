"""Ranges of step rates in which a condition holds, the holes between them, and the limit beyond the last.

A motor that loses steps near a resonance may hold again above it, so that one number is not sufficient. Rates are tried
in sequence over the whole search range, closely spaced where steps excite a resonance, and the ends of each range are
found by bisection.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from mechid.command import Command
from mechid.designs.settings import RATE
from mechid.plant.mechanism import Mechanism
from mechid.simulation.resonances import free_resonances

Range = tuple[float, float]


@dataclass(frozen=True)
class RateLimit:
    """Rates at which a stepping holds.

    Attributes
    ----------
    ranges : tuple of (float, float)
        From and to, full steps/s, ascending: all rates tried inside hold, those between ranges do not. The ends are
        accurate to half a percent. A rate that holds alone, with both neighbours failing, is not a range.
    searched : (float, float)
        Search range, full steps/s.
    brought_from : float
        Rate at which a slow start begins, full steps/s; 0 from rest.
    """

    ranges: tuple[Range, ...]
    searched: Range
    brought_from: float = 0.0

    @property
    def rate(self) -> float | None:
        """Rate up to which all hold; None if all searched rates hold, 0 if the lowest does not."""
        if not self.ranges or self.ranges[0][0] > self.searched[0]:
            return 0.0
        return self._unless_highest(self.ranges[0][1])

    @property
    def holds_again(self) -> bool:
        """Whether a range further up holds too, so that the loss is due to a resonance."""
        return bool(self.holes)

    @property
    def holes(self) -> tuple[Range, ...]:
        """Ranges in which steps are lost although higher rates hold, from and to, full steps/s."""
        ends = [self.searched[0], *(end for _, end in self.ranges)]
        return tuple((end, start) for end, (start, _) in zip(ends, self.ranges, strict=False) if start > end)

    @property
    def limit(self) -> float | None:
        """Rate beyond which none holds; None if the highest searched rate holds, 0 if no rate holds."""
        return self._unless_highest(self.ranges[-1][1]) if self.ranges else 0.0

    @property
    def widest(self) -> Range | None:
        """Widest of the ranges, None without any."""
        return max(self.ranges, key=lambda r: r[1] - r[0], default=None)

    def _unless_highest(self, rate: float) -> float | None:
        return rate if rate < self.searched[1] else None


def rates_to_try(mechanism: Mechanism, command: Command) -> list[float]:
    """Return the rates, full steps/s, at which a start is tried: closely spaced near a resonance of the mechanism.

    Resonances are those of its equations about the start angle of the command, with no friction holding.
    """
    met = [
        (RATE.around[0] * r.frequency_hz, RATE.around[1] * r.frequency_hz)
        for r in free_resonances(mechanism, command)
        if r.damping < RATE.swinging
    ]
    rates = [RATE.lowest]
    while rates[-1] < RATE.highest:
        rate = rates[-1]
        near = any(low <= rate <= high for low, high in met)
        following = max((RATE.near if near else RATE.far) * rate, rate + RATE.least)
        # The next wide step must not jump over the start of a resonance.
        begins = min((low for low, _ in met if rate < low < following), default=following)
        rates.append(min(begins, RATE.highest))
    return rates


def rate_limit(holds: Callable[[float], bool], rates: Sequence[float], brought_from: float = 0.0) -> RateLimit:
    """Return the ranges in which `holds` is true, tried at ascending rates and then between neighbours that differ."""
    found = [holds(rate) for rate in rates]
    for k in range(1, len(found) - 1):
        # A single rate that holds between failures is chance: the rotor may be caught by another pole pair in time.
        found[k] &= found[k - 1] or found[k + 1]
    ends = [rates[0]] if found[0] else []
    for (low, before), (high, after) in pairwise(zip(rates, found, strict=True)):
        if before != after:
            ends.append(_end(holds, low, high) if before else _end(holds, high, low))
    if found[-1]:
        ends.append(rates[-1])
    ranges = tuple(zip(ends[::2], ends[1::2], strict=True))
    return RateLimit(ranges, (rates[0], rates[-1]), brought_from)


def _end(holds: Callable[[float], bool], good: float, bad: float) -> float:
    """Return the last rate that holds between a good and a bad one."""
    while abs(math.log(bad / good)) > RATE.resolution:
        # Rates are spaced geometrically; the accuracy is relative.
        middle = math.sqrt(good * bad)
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good
