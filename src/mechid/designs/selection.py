"""The records that tell most in a given test time: greedy, then exchanged until none is better.

The best set is a knapsack problem. Greedy choice, then one record after another taken out, others tried in its place
and the time filled anew, is Fedorov's exchange with unequal costs (Fedorov 1972; Atkinson, Donev, Tobias 2007,
chapter 12).
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
    """What there is to choose from.

    Parameters
    ----------
    information : (points, records, n, n)
    before : (points, n, n)
        What is known without any of them.
    seconds : (records,)
        Test time of each, preparation included.
    total_s : float
    allowed : (records,) of bool
    most_of_one : int
        How often one record may be taken.
    """

    information: FloatArray
    before: FloatArray
    seconds: FloatArray
    total_s: float
    allowed: BoolArray
    most_of_one: int = 1


@dataclass(frozen=True)
class Choice:
    """Records chosen, in order of choice, and the criterion after each."""

    chosen: tuple[int, ...]
    trail: tuple[float, ...]

    @property
    def value(self) -> float:
        """The criterion of all."""
        return self.trail[-1]


def select(pool: Pool, criterion: Criterion, kept: Sequence[int] = ()) -> Choice:
    """Return the best records; `kept` ones are among them whatever they tell.

    Filled by gain per second and by gain alone, each exchanged, the better taken. Equal input gives equal output.
    """
    best: list[int] | None = None
    for per_second in (True, False):
        found = _filled(pool, criterion, list(kept), per_second=per_second)
        for _ in range(DESIGN.most_rounds):
            better = _exchanged(pool, criterion, found, len(kept))
            if better is found:
                break
            found = better
        if best is None or _value(pool, criterion, found) < _value(pool, criterion, best):
            best = found
    assert best is not None
    ordered = _ordered(pool, criterion, best)
    return Choice(tuple(ordered), _trail(pool, criterion, ordered))


def _exchanged(pool: Pool, criterion: Criterion, chosen: list[int], fixed: int) -> list[int]:
    """Return the best set after one round of taking each record out and filling the time anew, or the same."""
    best, value = chosen, _value(pool, criterion, chosen)
    for at in range(fixed, len(chosen)):
        rest = chosen[:at] + chosen[at + 1 :]
        for first in _promising(pool, criterion, rest, chosen[at]):
            tried = _filled(pool, criterion, [*rest, first])
            found = _value(pool, criterion, tried)
            if found < value - DESIGN.least_gain:
                best, value = tried, found
    return best


def _promising(pool: Pool, criterion: Criterion, rest: Sequence[int], out: int) -> list[int]:
    """Return what may come in place of a record that was taken out: the best by gain per second, and by gain."""
    fits = _fitting(pool, rest)
    fits = fits[fits != out]
    if not fits.size:
        return []
    gains = _gains(pool, criterion, _sum(pool, rest), fits)
    ranked = (np.argsort(-gains / pool.seconds[fits], kind="stable"), np.argsort(-gains, kind="stable"))
    return list(dict.fromkeys(int(fits[k]) for order in ranked for k in order[: DESIGN.tried]))


def _filled(pool: Pool, criterion: Criterion, chosen: list[int], *, per_second: bool = True) -> list[int]:
    """Add the record of the largest gain, or gain per second, until none fits."""
    chosen = chosen.copy()
    information = _sum(pool, chosen)
    while (fits := _fitting(pool, chosen)).size:
        gains = _gains(pool, criterion, information, fits)
        at = int(np.argmax(gains / pool.seconds[fits] if per_second else gains))
        if gains[at] < DESIGN.least_gain:
            break
        chosen.append(int(fits[at]))
        information = information + pool.information[:, fits[at]]
    return chosen


def _gains(pool: Pool, criterion: Criterion, information: FloatArray, records: IntArray) -> FloatArray:
    """Return by how much each record lowers the criterion, (records,)."""
    after = criterion.guided(information[:, None] + pool.information[:, records])
    return np.asarray(float(criterion.guided(information)) - after, dtype=np.float64)


def _fitting(pool: Pool, chosen: Sequence[int]) -> IntArray:
    left = pool.total_s - float(np.sum(pool.seconds[list(chosen)]))
    taken = np.bincount(np.asarray(chosen, dtype=np.int64), minlength=pool.seconds.size)
    fits = pool.allowed & (taken < pool.most_of_one) & (pool.seconds <= left * (1.0 + 1e-12))
    return np.flatnonzero(fits)


def _sum(pool: Pool, chosen: Sequence[int]) -> FloatArray:
    return np.asarray(pool.before + pool.information[:, list(chosen)].sum(axis=1))


def _value(pool: Pool, criterion: Criterion, chosen: Sequence[int]) -> float:
    return float(criterion.guided(_sum(pool, chosen)))


def _ordered(pool: Pool, criterion: Criterion, chosen: Sequence[int]) -> list[int]:
    """Return the records with those first that tell most."""
    left, out = list(chosen), list[int]()
    while left:
        gains = _gains(pool, criterion, _sum(pool, out), np.asarray(left, dtype=np.int64))
        out.append(left.pop(int(np.argmax(gains))))
    return out


def _trail(pool: Pool, criterion: Criterion, chosen: Sequence[int]) -> tuple[float, ...]:
    return tuple(float(criterion.of(_sum(pool, chosen[:k]))) for k in range(len(chosen) + 1))
