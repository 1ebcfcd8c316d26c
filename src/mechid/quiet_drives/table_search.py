"""Search for the table of least cost: damped Gauss-Newton from the nominal table, repeated with the rates it broke."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.errors import FitError
from mechid.plant.mechanism import Mechanism
from mechid.quiet_drives.linearised_cost import LinearisedCost
from mechid.quiet_drives.periodic_torque import PeriodicTorque, TorqueLines
from mechid.quiet_drives.quantity import TORQUE, Quantity
from mechid.quiet_drives.settings import QUIET
from mechid.quiet_drives.table_cost import Place, TableCost

LOSES_STEPS = "the rotor loses steps or the motion diverges"


@dataclass(frozen=True, eq=False)
class FoundTable:
    """Result of a search.

    Attributes
    ----------
    table : (4 n, 2)
    cost : TableCost
        With all rates that were added on the way.
    start_cost, end_cost : float
        Sums of squares.
    iterations : int
    """

    table: FloatArray
    cost: TableCost
    start_cost: float
    end_cost: float
    iterations: int


def design_places(
    mechanisms: Sequence[Mechanism],
    base: FloatArray,
    rates: Sequence[float],
    ends: tuple[float, float],
    quantity: Quantity = TORQUE,
) -> list[Place]:
    """Return the places of a cost: design rates for all mechanisms, their neighbours and the range for the first.

    Parameters
    ----------
    mechanisms : sequence of Mechanism
        The nominal one first, then draws.
    base : (4 n, 2)
        Nominal table.
    rates : sequence of float
        Design rates, full steps/s.
    ends : (float, float)
        Range of rates, full steps/s.
    quantity : Quantity
        Whose lines the cost weighs.

    Raises
    ------
    FitError
        The nominal table loses steps at a rate.
    """
    beside: list[float] = []
    for rate in rates:
        near = [rate * share for share in QUIET.near]
        beside += [one for one in near if ends[0] <= one <= ends[1] and not _has_near(one, (*rates, *beside))]
    others = [
        rate for rate in np.geomspace(*ends, QUIET.range_rates).tolist() if not _has_near(rate, (*rates, *beside))
    ]
    weight = 1.0 / np.sqrt(len(rates))
    shared = weight / np.sqrt(len(mechanisms))
    own = [Place(*_nominal(mechanism, rate, base, quantity), shared) for mechanism in mechanisms for rate in rates]
    near_ones = [Place(*_nominal(mechanisms[0], rate, base, quantity), QUIET.near_weight * weight) for rate in beside]
    return [*own, *near_ones, *range_places(mechanisms[0], base, others, quantity)]


def range_places(
    mechanism: Mechanism, base: FloatArray, rates: Sequence[float], quantity: Quantity = TORQUE
) -> list[Place]:
    """Return places at which only the level is limited."""
    return [Place(*_nominal(mechanism, rate, base, quantity), 0.0) for rate in rates]


def search_table(
    cost: TableCost,
    changes: FloatArray,
    checked: Sequence[Place],
    say: Callable[[str], None],
) -> FoundTable:
    """Return the table of least cost that is nowhere louder than promised, as far as it can be found.

    Parameters
    ----------
    cost : TableCost
    changes : (m, 4 n, 2)
        Changes that the search combines.
    checked : sequence of Place
        Places at which the level is checked after a search; those at which it is too high join the cost.
    say : callable
        Receives progress lines.
    """
    c, iterations, start = np.zeros(len(changes)), 0, 0.0
    for attempt in range(QUIET.rounds):
        c, first, last, count = _gauss_newton(cost, changes, c, say)
        start, iterations = start or first, iterations + count
        table = cost.base + np.tensordot(c, changes, axes=1)
        broken = [place for place in checked if rise_db(place, table) > QUIET.promised_rise_db]
        if not broken or attempt + 1 == QUIET.rounds:
            break
        say(f"louder than the nominal table at {len(broken)} further rates, which join the cost")
        raised = [replace(place, limit_weight=QUIET.raised_limit * place.limit_weight) for place in broken]
        known = {id(place.torque) for place in broken}
        cost = replace(cost, places=[*(p for p in cost.places if id(p.torque) not in known), *raised])
        checked = [*(p for p in checked if id(p.torque) not in known), *raised]
    table = cost.base + np.tensordot(c, changes, axes=1)
    # Cutting single values off would bring the lines back that the others cancel; a smaller table keeps its shape.
    table *= min(1.0, cost.peak / float(np.abs(table).max()))
    return FoundTable(table, cost, start, last, iterations)


def rise_db(place: Place, table: FloatArray) -> float:
    """Return the level of a table over that of the nominal one at a place, dB; infinite if steps are lost."""
    lines = place.torque.lines(table)
    return float("inf") if lines is None else 20.0 * float(np.log10(max(lines.level, 1e-300) / place.nominal.level))


def _gauss_newton(
    cost: TableCost, changes: FloatArray, c: FloatArray, say: Callable[[str], None]
) -> tuple[FloatArray, float, float, int]:
    """Return coefficients, first and last cost, and the number of steps.

    Limits make the cost kinked, the lines are smooth: each step minimises the full cost of linearised lines.
    """
    table = cost.base + np.tensordot(c, changes, axes=1)
    found = cost.simulate(table, changes)
    if found is None:
        raise FitError(f"microstep table: {LOSES_STEPS} at a rate of the range")
    value = begun = cost.value(found, table)
    damping, count = QUIET.damping, 0
    for count in range(1, QUIET.iterations + 1):
        before, model = value, LinearisedCost(cost, found, table, changes)
        while damping < QUIET.largest_damping:
            step = model.minimise(damping)
            moved = table + np.tensordot(step, changes, axes=1)
            tried = cost.simulate(moved)
            if tried is not None and (value := cost.value(tried, moved)) < before:
                break
            damping *= QUIET.raised
        else:
            return c, begun, before, count
        c, table, damping = c + step, moved, damping / QUIET.raised
        say(f"table: step {count}, cost {value:.4g}")
        if before - value < QUIET.converged * before or count == QUIET.iterations:
            break
        further = cost.simulate(table, changes)
        if further is None:
            break
        found = further
    return c, begun, value, count


def _nominal(
    mechanism: Mechanism, rate: float, base: FloatArray, quantity: Quantity
) -> tuple[PeriodicTorque, TorqueLines]:
    torque = PeriodicTorque(mechanism, rate, quantity)
    lines = torque.lines(base)
    if lines is None:
        raise FitError(
            f"at {rate:.6g} full steps/s the nominal table fails: {LOSES_STEPS}; leave this rate out of rates and range"
        )
    return torque, lines


def _has_near(rate: float, others: Sequence[float]) -> bool:
    return any(abs(rate / other - 1.0) < QUIET.same_rate for other in others)
