"""Removal of mains hum from a residual, before its lines are attributed to the mechanism."""

from __future__ import annotations

from collections.abc import Sequence

from mechid.analysis.order_tracking import travel_windows
from mechid.analysis.settings import ORDER
from mechid.signal.grid import HumSeries, drifting_lines, evident_grid
from mechid.signal.remainder import Remainder
from mechid.signal.series import Series
from mechid.signal.settings import HUM
from mechid.signal.trend import fit_line


def remove_hum(
    residual: Series, travel: Series, sample_rate_hz: float, mains_hz: float, orders: Sequence[float]
) -> tuple[Series, frozenset[float]]:
    """Remove multiples of the mains frequency; also return the orders that cannot be separated from them.

    If the rate varies, the orders only cross the multiples and are kept. At a steady rate, a multiple that coincides
    with an order stays in the residual, and the record gives no information on that order.

    Parameters
    ----------
    residual : Series of N samples
    travel : Series of N samples
        Full steps travelled.
    sample_rate_hz, mains_hz : float
    orders : sequence of float
        Multiples of the step rate.
    """
    rates = [window.rate for window in travel_windows(travel, sample_rate_hz)]
    if not rates:
        return residual, frozenset()
    rate, duration_s = sum(rates) / len(rates), residual.size / sample_rate_hz
    # At a varying rate, orders cross the hum and can be separated from it.
    steady = max(rates) <= (1.0 + ORDER.steady) * min(rates)

    def nearest(hz: float) -> float:
        return min(abs(hz - order * rate) for order in orders) if steady else float("inf")

    own = HumSeries(residual, sample_rate_hz, lambda hz, reach: nearest(hz) > reach)
    grid = evident_grid([own], mains_hz)
    hz = grid.own_hz[0] if grid else mains_hz
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
