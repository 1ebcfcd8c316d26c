"""The records that tell most in a given test time: greedy, then exchanged until none is better.

The best set is a knapsack problem; greedy choice by gain per second, then taking each record out and filling anew, is
Fedorov's exchange with unequal costs (Fedorov 1972; Atkinson, Donev, Tobias 2007, chapter 12).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechid.design.criterion import Criterion

FloatArray = NDArray[np.float64]
LEAST_GAIN = 1e-6
MOST_ROUNDS = 8


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
    allowed: NDArray[np.bool_]
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

    The last record of a round is exchanged first. Equal input gives equal output: nothing is drawn.
    """
    best = _filled(pool, criterion, list(kept))
    for _ in range(MOST_ROUNDS):
        better = _exchanged(pool, criterion, best, len(kept))
        if better is best:
            break
        best = better
    return Choice(tuple(best), _trail(pool, criterion, best))


def _exchanged(pool: Pool, criterion: Criterion, chosen: list[int], fixed: int) -> list[int]:
    """Return the set after one round of taking each record out and filling the time anew."""
    best, value = chosen, _value(pool, criterion, chosen)
    for k in sorted(set(chosen[fixed:]), reverse=True):
        rest = best.copy()
        if k not in rest[fixed:]:
            continue
        rest.reverse()
        rest.remove(k)
        rest.reverse()
        tried = _filled(pool, criterion, rest, without=k)
        found = _value(pool, criterion, tried)
        if found < value - LEAST_GAIN:
            best, value = tried, found
    return best


def _filled(pool: Pool, criterion: Criterion, chosen: list[int], without: int | None = None) -> list[int]:
    """Add records by gain per second until none fits; the first of them is not `without`."""
    chosen = chosen.copy()
    information = _sum(pool, chosen)
    now = float(criterion.of(information))
    first = True
    while True:
        fits = _fitting(pool, chosen)
        if first and without is not None:
            fits = fits[fits != without]
        if not fits.size:
            return chosen
        gains = now - criterion.of(information[:, None] + pool.information[:, fits])
        at = int(np.argmax(gains / pool.seconds[fits]))
        if gains[at] < LEAST_GAIN:
            return chosen
        first, k = False, int(fits[at])
        chosen.append(k)
        information = information + pool.information[:, k]
        now -= float(gains[at])


def _fitting(pool: Pool, chosen: Sequence[int]) -> NDArray[np.int64]:
    left = pool.total_s - float(np.sum(pool.seconds[list(chosen)]))
    taken = np.bincount(np.asarray(chosen, dtype=np.int64), minlength=pool.seconds.size)
    fits = pool.allowed & (taken < pool.most_of_one) & (pool.seconds <= left * (1.0 + 1e-12))
    return np.flatnonzero(fits)


def _sum(pool: Pool, chosen: Sequence[int]) -> FloatArray:
    return np.asarray(pool.before + pool.information[:, list(chosen)].sum(axis=1))


def _value(pool: Pool, criterion: Criterion, chosen: Sequence[int]) -> float:
    return float(criterion.of(_sum(pool, chosen)))


def _trail(pool: Pool, criterion: Criterion, chosen: Sequence[int]) -> tuple[float, ...]:
    return tuple(_value(pool, criterion, chosen[:k]) for k in range(len(chosen) + 1))
