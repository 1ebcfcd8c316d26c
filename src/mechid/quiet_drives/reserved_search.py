"""Search for a table that keeps its share of the torque reserve."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from mechid.arrays import FloatArray
from mechid.plant.mechanism import Mechanism
from mechid.plant.stepper import HOLDING
from mechid.quiet_drives.settings import QUIET
from mechid.quiet_drives.step_reserve import blend_to_reserve, least_fundamental, torque_reserve
from mechid.quiet_drives.table_cost import Place, TableCost
from mechid.quiet_drives.table_search import FoundTable, search_table


def search_within_reserve(
    mechanism: Mechanism,
    cost: TableCost,
    changes: FloatArray,
    checked: Sequence[Place],
    rates: Sequence[float],
    least_share: float,
    say: Callable[[str], None],
) -> tuple[FoundTable, FloatArray, float]:
    """Return the search, the table that keeps the reserve, and the share of the found change that it holds.

    The fundamental says what a smoothly turning rotor can give; where simulation finds less, the least one rises by
    the difference and the table is searched for again. What is still missing then is met by less of the change.

    Parameters
    ----------
    mechanism : Mechanism
    cost : TableCost
    changes, checked, say
        As of `search_table`.
    rates : sequence of float
        Design rates, full steps/s, at which the reserve is kept.
    least_share : float
        Least reserve relative to that of the nominal table.
    """
    holding = mechanism.scale(HOLDING) or 1.0
    nominal = [torque_reserve(mechanism, cost.base, rate) for rate in rates]
    least = least_fundamental(mechanism, nominal, least_share)
    for _ in range(QUIET.tightenings):
        found = search_table(replace(cost, least_fundamental=least), changes, checked, say)
        own = [torque_reserve(mechanism, found.table, rate) for rate in rates]
        lacking = max((least_share * n - r for n, r in zip(nominal, own, strict=True)), default=0.0) / holding
        if lacking <= 0.0:
            return found, found.table, 1.0
        say(f"the torque reserve lacks {100.0 * lacking:.1f} % of the holding torque: search with a larger fundamental")
        # Less than the resolution of a reserve would change nothing that the next one can show.
        least = min(least + QUIET.tightened * max(lacking, QUIET.reserve_resolution), 1.0)
    table, kept = blend_to_reserve(mechanism, cost.base, found.table, rates, least_share)
    return found, table, kept
