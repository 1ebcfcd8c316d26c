"""Mains hum in what a fit leaves of a record: removed before lines are read as the mechanism's emission."""

from __future__ import annotations

from collections.abc import Sequence

from mechid.analysis.order_tracking import travel_windows
from mechid.analysis.settings import ORDER
from mechid.signal.grid import HumSeries, drifting_lines, evident_grid
from mechid.signal.remainder import Remainder
from mechid.signal.series import Series
from mechid.signal.settings import HUM
from mechid.signal.trend import fit_line


def without_hum(
    residual: Series, travel: Series, sample_rate_hz: float, mains_hz: float, orders: Sequence[float]
) -> tuple[Series, frozenset[float]]:
    """Return a residual without multiples of the mains' frequency, and the orders that it does not tell from them.

    Where the rate varies, orders cross the multiples and stay. At a steady rate a multiple that an order coincides with
    stays in the residual, and the order is none that the record tells.

    Parameters
    ----------
    residual : Series of N samples
    travel : Series of N samples
        Full steps travelled.
    sample_rate_hz, mains_hz : float
    orders : sequence of float
        Of the step rate.
    """
    rates = [window.rate for window in travel_windows(travel, sample_rate_hz)]
    if not rates:
        return residual, frozenset()
    rate, duration_s = sum(rates) / len(rates), residual.size / sample_rate_hz
    steady = max(rates) <= (1.0 + ORDER.steady) * min(rates)

    def nearest(hz: float) -> float:
        return min(abs(hz - order * rate) for order in orders) if steady else float("inf")

    own = HumSeries(residual, sample_rate_hz, lambda hz, reach: nearest(hz) > reach)
    told = evident_grid([own], mains_hz)
    hz = told.own_hz[0] if told else mains_hz
    top = min(HUM.highest_hz, 0.45 * sample_rate_hz)
    multiples = [k * hz for k in range(1, int(top / hz) + 1)]
    apart = [line for line in multiples if nearest(line) > ORDER.hum_apart / duration_s]
    lines = [
        f
        for line in apart
        for f in (drifting_lines(own, line) if nearest(line) > ORDER.hum_room / duration_s else (line,))
    ]
    near = (order for order in orders for line in multiples if abs(order * rate - line) <= ORDER.hum_apart / duration_s)
    hidden = frozenset(near) if steady else frozenset()
    turns = [line / sample_rate_hz for line in lines]
    return Remainder(residual, fit_line(residual, 0, None, turns)), hidden
