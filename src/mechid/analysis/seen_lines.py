"""Lines of a spectrum with what they may be: orders of the step rate, mains hum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mechid.analysis.settings import ORDER
from mechid.signal.lines import Line
from mechid.signal.mains import MainsLine


@dataclass(frozen=True, kw_only=True)
class SeenLine:
    """A line of a channel's spectrum, and what it may be.

    Attributes
    ----------
    line : Line
    order : float or None
        Multiple of a constant step rate.
    mains : MainsLine or None
        Multiple of the mains' frequency.
    """

    line: Line
    order: float | None
    mains: MainsLine | None


def seen_line(line: Line, mains: Sequence[MainsLine], rate: float | None, bin_hz: float) -> SeenLine:
    """Return a line with what it may be."""
    near = [one for one in mains if abs(one.line.frequency_hz - line.frequency_hz) < bin_hz]
    orders = (_order(line.frequency_hz, rate, parts, bin_hz) for parts in (1, ORDER.quarters) if rate)
    order = next((order for order in orders if order), None)
    return SeenLine(line=line, order=order, mains=near[0] if near else None)


def _order(frequency_hz: float, rate: float, parts: int, bin_hz: float) -> float | None:
    """Return the order of a line in whole parts of the rate; None where it is none, or may well be so by chance."""
    order = round(parts * frequency_hz / rate) / parts
    near = max(ORDER.near_bins * bin_hz, ORDER.near * frequency_hz)
    is_one = order > 0.0 and abs(order * rate - frequency_hz) <= near
    return order if is_one and 2.0 * near * parts <= ORDER.by_chance * rate else None
