"""Commanded rate over time: piecewise linear, jumps allowed, constant outside its breakpoints."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from mechid.command.entry import format_found, is_number
from mechid.errors import UsageError


def first_fault(times_s: Sequence[float], rates: Sequence[float]) -> tuple[int, str] | None:
    """Return the position of the first invalid breakpoint and the fault, or None."""
    for at, (time, rate) in enumerate(zip(times_s, rates, strict=True)):
        if not (is_number(time) and is_number(rate)):
            return at, f"found [{format_found(time)}, {format_found(rate)}]; write two finite numbers"
        if at >= 1 and time < times_s[at - 1]:
            return at, f"time {time} s comes after {times_s[at - 1]} s; put the times in ascending order"
        if at >= 2 and time == times_s[at - 2]:
            return at, f"third breakpoint at {time} s; a jump has two, the rate before and the rate after"
    return None


@dataclass(frozen=True)
class RateProfile:
    """Rate of a step command, linear between breakpoints, constant before the first and after the last.

    Two breakpoints at the same time are a jump. The command starts at t = 0: breakpoints at earlier times matter
    only through the line that they define across zero.

    Parameters
    ----------
    times_s : tuple of float, (B,)
        Times of the breakpoints in s of command time, ascending.
    rates : tuple of float, (B,)
        Rates there in full steps/s; negative rates step back, zero dwells.

    Raises
    ------
    UsageError
        There is no breakpoint, or an invalid one.

    Examples
    --------
    >>> RateProfile.through([(0.0, 0.0), (60.0, 120.0)])
    RateProfile(times_s=(0.0, 60.0), rates=(0.0, 120.0))
    """

    times_s: tuple[float, ...]
    rates: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.times_s) != len(self.rates) or not self.times_s:
            counts = f"{len(self.times_s)} times and {len(self.rates)} rates"
            raise UsageError(f"rate profile: found {counts}; give one rate to each time, one pair or more")
        fault = first_fault(self.times_s, self.rates)
        if fault is not None:
            raise UsageError(f"rate profile: [{fault[0]}]: {fault[1]}")

    @classmethod
    def constant(cls, rate: float) -> RateProfile:
        """Return the profile of a constant rate in full steps/s."""
        return cls(times_s=(0.0,), rates=(rate,))

    @classmethod
    def through(cls, points: Iterable[tuple[float, float]]) -> RateProfile:
        """Return the profile through points (time in s, rate in full steps/s)."""
        pairs = list(points)
        return cls(times_s=tuple(time for time, _ in pairs), rates=tuple(rate for _, rate in pairs))

    def at(self, time_s: float) -> float:
        """Return the rate at an instant in s, in full steps/s; at a jump, the rate after it.

        Examples
        --------
        >>> RateProfile.through([(0.0, 0.0), (60.0, 120.0), (60.0, 0.0)]).at(30.0)
        60.0
        """
        after = bisect_right(self.times_s, time_s)
        if after in (0, len(self.times_s)):
            return self.rates[min(after, len(self.times_s) - 1)]
        (start, end), (rate, last) = self.times_s[after - 1 : after + 1], self.rates[after - 1 : after + 1]
        return rate + (last - rate) * (time_s - start) / (end - start)
