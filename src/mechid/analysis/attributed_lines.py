"""Attribution of spectral lines to orders of the step rate, to named lines of the mechanism, or to mains hum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mechid.analysis.settings import ORDER
from mechid.plant.mechanism import NamedLine
from mechid.signal.lines import Line
from mechid.signal.mains import MainsLine


@dataclass(frozen=True, kw_only=True)
class AttributedLine:
    """A line of a channel's spectrum, with its possible origins.

    Attributes
    ----------
    line : Line
    order : float or None
        Multiple of a constant step rate; None if it is none.
    mains : MainsLine or None
        Multiple of the mains frequency; None if it is none.
    named : tuple of NamedLine
        Lines that the mechanism names, as of its tooth meshes, at this frequency; several if they are too close.
    """

    line: Line
    order: float | None
    mains: MainsLine | None
    named: tuple[NamedLine, ...] = ()


def attribute_line(
    line: Line,
    mains: Sequence[MainsLine],
    rate: float | None,
    bin_hz: float,
    sample_rate_hz: float,
    named: Sequence[NamedLine] = (),
    *,
    parts: int = ORDER.quarters,
) -> AttributedLine:
    """Attribute a line to an order of the step rate, named lines and mains hum, where its frequency matches.

    `parts` is the denominator of fractional orders: the full steps of an electrical period.
    """
    near = [one for one in mains if abs(one.line.frequency_hz - line.frequency_hz) < bin_hz]
    # Integer orders first: they are more likely, and a match by chance is rarer among them.
    orders = (_order(line.frequency_hz, rate, each, bin_hz) for each in (1, parts) if rate)
    order = next((order for order in orders if order), None)
    reach = _reach(line.frequency_hz, bin_hz)
    own = [one for one in named if any(abs(f - line.frequency_hz) <= reach for f in one.lines_hz(rate, sample_rate_hz))]
    return AttributedLine(line=line, order=order, mains=near[0] if near else None, named=tuple(own))


def _reach(frequency_hz: float, bin_hz: float) -> float:
    """Return the distance in Hz within which a line is at an order."""
    return max(ORDER.near_bins * bin_hz, ORDER.near * frequency_hz)


def _order(frequency_hz: float, rate: float, parts: int, bin_hz: float) -> float | None:
    """Return the order of a line in multiples of rate / parts; None if it has none, or if chance explains the match."""
    order = round(parts * frequency_hz / rate) / parts
    near = _reach(frequency_hz, bin_hz)
    is_one = order > 0.0 and abs(order * rate - frequency_hz) <= near
    # Close multiples match many lines by chance, which is then no evidence.
    return order if is_one and 2.0 * near * parts <= ORDER.by_chance * rate else None
