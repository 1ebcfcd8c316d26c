"""Selection of the most informative records in a given test time, by greedy choice and exchange.

The best set is a knapsack problem. A greedy choice is improved by removing one record after another, trying others in
its place and filling the remaining time again: Fedorov's exchange with unequal costs (Fedorov 1972; Atkinson, Donev,
Tobias 2007, chapter 12).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import BoolArray, FloatArray, IntArray
from mechid.designs.criterion import Criterion
from mechid.designs.settings import DESIGN


@dataclass(frozen=True, eq=False)
class Pool:
    """Records to choose from.

    Parameters
    ----------
    information : (points, records, n, n)
    before : (points, n, n)
        Information without any of them.
    seconds : (records,)
        Test time of each, preparation included.
    total_s : float
    allowed : (records,) of bool
    most_of_one : int
        Largest number of repetitions of one record.
    """

    information: FloatArray
    before: FloatArray
    seconds: FloatArray
    total_s: float
    allowed: BoolArray
    most_of_one: int = 1


@dataclass(frozen=True)
class Choice:
    """Chosen records in order of choice; the criterion before the first, and after each."""

    chosen: tuple[int, ...]
    trail: tuple[float, ...]

    @property
    def value(self) -> float:
        """Criterion of all records together."""
        return self.trail[-1]


def select(pool: Pool, criterion: Criterion, kept: Sequence[int] = ()) -> Choice:
    """Return a good set of records, found greedily; `kept` ones are always included.

    The time is filled once by gain per second and once by gain alone, each result is improved by exchange, and the
    better one is returned. Equal input gives equal output.
    """
    best: list[int] | None = None
    # Gain per second misses a long record that alone determines a parameter; gain alone wastes time.
    for per_second in (True, False):
        found = _fill(pool, criterion, list(kept), per_second=per_second)
        for _ in range(DESIGN.most_rounds):
            better = _exchange_round(pool, criterion, found, len(kept))
            # A round without improvement returns the same list: no further round can improve it.
            if better is found:
                break
            found = better
        if best is None or _value(pool, criterion, found) < _value(pool, criterion, best):
            best = found
    assert best is not None
    ordered = _order_by_gain(pool, criterion, best)
    return Choice(tuple(ordered), _trail(pool, criterion, ordered))


def _exchange_round(pool: Pool, criterion: Criterion, chosen: list[int], fixed: int) -> list[int]:
    """Return the best set after one round of removing each record and filling the time again, or the same set."""
    best, value = chosen, _value(pool, criterion, chosen)
    # Records to be kept come first in the list and are never exchanged.
    for at in range(fixed, len(chosen)):
        rest = chosen[:at] + chosen[at + 1 :]
        for first in _replacements(pool, criterion, rest, chosen[at]):
            tried = _fill(pool, criterion, [*rest, first])
            found = _value(pool, criterion, tried)
            if found < value - DESIGN.least_gain:
                best, value = tried, found
    return best


def _replacements(pool: Pool, criterion: Criterion, rest: Sequence[int], out: int) -> list[int]:
    """Return candidates for the place of a removed record: the best by gain per second, and by gain."""
    fits = _affordable(pool, rest)
    fits = fits[fits != out]
    if not fits.size:
        return []
    gains = _gains(pool, criterion, _sum(pool, rest), fits)
    # A stable sort breaks ties by the order of the pool, so that equal input gives equal output.
    ranked = (np.argsort(-gains / pool.seconds[fits], kind="stable"), np.argsort(-gains, kind="stable"))
    return list(dict.fromkeys(int(fits[k]) for order in ranked for k in order[: DESIGN.tried]))


def _fill(pool: Pool, criterion: Criterion, chosen: list[int], *, per_second: bool = True) -> list[int]:
    """Add the record with the largest gain, or gain per second, until none fits."""
    chosen = chosen.copy()
    information = _sum(pool, chosen)
    while (fits := _affordable(pool, chosen)).size:
        gains = _gains(pool, criterion, information, fits)
        at = int(np.argmax(gains / pool.seconds[fits] if per_second else gains))
        if gains[at] < DESIGN.least_gain:
            break
        chosen.append(int(fits[at]))
        information = information + pool.information[:, fits[at]]
    return chosen


def _gains(pool: Pool, criterion: Criterion, information: FloatArray, records: IntArray) -> FloatArray:
    """Return the decrease of the criterion by each record, (records,)."""
    after = criterion.guided_value(information[:, None] + pool.information[:, records])
    return np.asarray(float(criterion.guided_value(information)) - after, dtype=np.float64)


def _affordable(pool: Pool, chosen: Sequence[int]) -> IntArray:
    left = pool.total_s - float(np.sum(pool.seconds[list(chosen)]))
    taken = np.bincount(np.asarray(chosen, dtype=np.int64), minlength=pool.seconds.size)
    # Times that add exactly to the test time must fit in spite of rounding.
    fits = pool.allowed & (taken < pool.most_of_one) & (pool.seconds <= left * (1.0 + 1e-12))
    return np.flatnonzero(fits)


def _sum(pool: Pool, chosen: Sequence[int]) -> FloatArray:
    return np.asarray(pool.before + pool.information[:, list(chosen)].sum(axis=1))


def _value(pool: Pool, criterion: Criterion, chosen: Sequence[int]) -> float:
    return float(criterion.guided_value(_sum(pool, chosen)))


def _order_by_gain(pool: Pool, criterion: Criterion, chosen: Sequence[int]) -> list[int]:
    """Return the records, the most informative first."""
    left, out = list(chosen), list[int]()
    while left:
        gains = _gains(pool, criterion, _sum(pool, out), np.asarray(left, dtype=np.int64))
        out.append(left.pop(int(np.argmax(gains))))
    return out


def _trail(pool: Pool, criterion: Criterion, chosen: Sequence[int]) -> tuple[float, ...]:
    return tuple(float(criterion.of(_sum(pool, chosen[:k]))) for k in range(len(chosen) + 1))
