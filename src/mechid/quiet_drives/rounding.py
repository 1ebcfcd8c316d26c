"""Rounding of a table to a converter's codes, by coordinate descent on the cost of the search.

A code c of b bits stands for c / (2^(b-1) - 1) of the full scale, which is the peak. Plain rounding spreads its errors
over all lines. Here the entries are rounded one after the other, each time with the remaining ones at their best real
values (the nearest plane of [Babai1986]_ in the metric of the cost), in several orders; single codes and pairs of them
then descend. All this runs on the cost linearised about the last table, and a result is kept only if the true cost of
its simulation is lower.

.. [Babai1986] L. Babai, On Lovasz' lattice reduction and the nearest lattice point problem, Combinatorica 6 (1986).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.quiet_drives.linearised_cost import LinearisedCost
from mechid.quiet_drives.settings import QUIET
from mechid.quiet_drives.table_cost import TableCost


@dataclass(frozen=True, eq=False)
class RoundedTable:
    """A table of codes.

    Attributes
    ----------
    codes : (4 n, 2) int
    full_scale : float
        Value of the largest code, as a fraction of the nominal peak.
    bits : int
    cost : float
        True cost; infinite if the rotor loses steps.
    plain_cost : float
        True cost of plain rounding.
    """

    codes: IntArray
    full_scale: float
    bits: int
    cost: float
    plain_cost: float

    @property
    def values(self) -> FloatArray:
        """Values of the codes, (4 n, 2), fractions of the nominal peak."""
        return np.asarray(self.codes * (self.full_scale / largest_code(self.bits)), dtype=np.float64)


def largest_code(bits: int) -> int:
    """Return the largest code of a signed converter; the most negative one is not used, so that codes mirror.

    Examples
    --------
    >>> largest_code(8)
    127
    """
    return int(2 ** (bits - 1)) - 1


def plain_codes(table: FloatArray, bits: int, full_scale: float = 1.0) -> IntArray:
    """Return the nearest codes of a table, (4 n, 2)."""
    largest = largest_code(bits)
    codes = np.rint(table / full_scale * largest).astype(np.int64)
    return np.clip(codes, -largest, largest)


def round_table(
    table: FloatArray,
    cost: TableCost,
    entries: FloatArray,
    bits: int,
    full_scale: float,
    is_allowed: Callable[[FloatArray], bool] = lambda _: True,
) -> RoundedTable:
    """Return the codes of a table at which the cost is lowest, as far as the descent finds it.

    Parameters
    ----------
    table : (4 n, 2)
    cost : TableCost
    entries : (m, 4 n, 2)
        Changes of single entries, as `table_entries` makes them.
    bits : int
    full_scale : float
    is_allowed : callable
        Rule that a table has to keep beside its cost; plain rounding is used against it only if nothing else is found.
    """
    unit, largest = full_scale / largest_code(bits), largest_code(bits)
    codes = plain_codes(table, bits, full_scale)
    best = plain = _true_cost(cost, codes, unit)
    if not is_allowed(np.asarray(unit * codes, dtype=np.float64)):
        best = np.inf  # any table that keeps the rule is better than this one
    about = table
    for _ in range(QUIET.linearisations):
        found = cost.simulate(about, unit * entries)
        if found is None:
            break
        model = LinearisedCost(cost, found, about, unit * entries)
        tried = _likely_codes(model, about / unit, entries, largest)
        values = [_true_cost(cost, own, unit) for own in tried]
        better = [k for k in np.argsort(values) if values[k] < best]
        chosen = next((k for k in better if is_allowed(np.asarray(unit * tried[k], dtype=np.float64))), None)
        if chosen is None:
            break
        codes, best = tried[chosen], values[chosen]
        about = np.asarray(unit * codes, dtype=np.float64)
    return RoundedTable(codes, full_scale, bits, best if np.isfinite(best) else plain, plain)


def _true_cost(cost: TableCost, codes: IntArray, unit: float) -> float:
    table = np.asarray(unit * codes, dtype=np.float64)
    found = cost.simulate(table)
    return float("inf") if found is None else cost.value(found, table)


def _likely_codes(model: LinearisedCost, about: FloatArray, entries: FloatArray, largest: int) -> list[IntArray]:
    """Return the tables of codes, (4 n, 2) each, that cost least by linear lines, about a table in units of a code.

    How much the range and the distance should weigh differs from mechanism to mechanism: several weights are tried.
    """
    places = np.abs(entries).reshape(len(entries), -1).argmax(axis=1)
    found: dict[bytes, tuple[float, IntArray]] = {}
    for range_weight in QUIET.range_weights:
        A, g = model.smooth_part(range_weight)
        for near in QUIET.nearness:
            codes = _nearest_codes(about, A, g, entries, largest, near)
            found[codes.tobytes()] = (model.predict((codes - about).ravel()[places]), codes)
    return [codes for _, codes in sorted(found.values(), key=lambda one: one[0])[: QUIET.codes_simulated]]


def _nearest_codes(
    about: FloatArray, A: FloatArray, g: FloatArray, entries: FloatArray, largest: int, near: float
) -> IntArray:
    """Return the codes, (4 n, 2), of least linearised cost about a table in units of a code.

    `near` weighs the distance from the table, relative to the mean curvature of the cost: the lines are linear nearby.
    """
    rng = np.random.default_rng(0)
    places = np.abs(entries).reshape(len(entries), -1).argmax(axis=1)
    start = about.ravel()[places]
    A = A + near * np.trace(A) / len(A) * np.eye(len(A))

    def cost(codes: FloatArray) -> float:
        move = codes - start
        return float(move @ A @ move + 2.0 * g @ move)

    orders = [np.arange(start.size), *(rng.permutation(start.size) for _ in range(QUIET.orders_tried - 1))]
    rounded = [np.clip(_nearest_plane(start, A, g, order), -largest, largest) for order in orders]
    # A descent takes far longer than a rounding, and starts from all of them ended no better.
    likely = sorted(rounded, key=cost)[: QUIET.descents]
    best = min((_descend(codes, start, A, g, largest) for codes in likely), key=cost)
    whole = np.zeros(about.size)
    for entry, place, code in zip(entries.reshape(len(entries), -1), places, best, strict=True):
        whole += entry * (code * entry[place])
    return np.rint(whole).astype(np.int64).reshape(about.shape)


def _nearest_plane(start: FloatArray, A: FloatArray, g: FloatArray, order: IntArray) -> FloatArray:
    """Return rounded codes, (m,), each rounded with those after it at their best real values."""
    own = A[np.ix_(order, order)]
    # Upper triangle R with A = R' R: rounding runs from the last coordinate to the first.
    R = np.linalg.cholesky(own).T
    target = R @ start[order] - np.linalg.solve(R.T, g[order])
    codes = np.zeros(start.size)
    for k in range(start.size - 1, -1, -1):
        codes[k] = np.rint((target[k] - R[k, k + 1 :] @ codes[k + 1 :]) / R[k, k])
    out = np.empty(start.size)
    out[order] = codes
    return out


def _descend(codes: FloatArray, start: FloatArray, A: FloatArray, g: FloatArray, largest: int) -> FloatArray:
    """Return codes, (m,), at which no change of one code, or of two by one each, lowers the linearised cost."""
    codes, m = codes.copy(), codes.size
    slope = g + A @ (codes - start)
    diagonal = np.diag(A)
    for _ in range(QUIET.sweeps * m):
        # Change of the cost by a pair of moves (s, t) of entries i and j; i = j is a single move.
        up = np.where(codes < largest, diagonal + 2.0 * slope, np.inf)
        down = np.where(codes > -largest, diagonal - 2.0 * slope, np.inf)
        single = np.concatenate([up, down])
        sign = np.concatenate([np.ones(m), -np.ones(m)])
        both = single[:, None] + single + 2.0 * sign[:, None] * sign * np.tile(A, (2, 2))
        # The same entry twice is no pair.
        index = np.arange(2 * m)
        both[index, index] = np.inf
        both[index, (index + m) % (2 * m)] = np.inf
        one, two = int(single.argmin()), int(both.argmin())
        i, j = divmod(two, 2 * m)
        moves = [one] if single[one] <= both[i, j] else [i, j]
        if min(single[one], both[i, j]) >= -1e-12 * diagonal.max():
            break
        for at in moves:
            codes[at % m] += sign[at]
            slope += sign[at] * A[:, at % m]
    return codes
