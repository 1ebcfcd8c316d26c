"""The motion that repeats, by shooting: Newton's method on the period map, and the multipliers of what it finds.

With F the map over m periods and M = dF/dx at its fixed point x*, a deviation grows by M in their time: the
eigenvalues of M are the Floquet multipliers, and the motion is stable where all are inside the unit circle. The fixed
point's derivative to the parameters is (I - M)^-1 F_p, also where transients take long.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.period_map import Image, PeriodMap
from mechid.budgets.settings import MOTION


@dataclass(frozen=True, eq=False)
class Orbit:
    """A motion that repeats.

    Attributes
    ----------
    x : (n,)
        State at its start.
    by_parameter : (n, p)
        Derivative of that state to the parameters.
    periods : int
        It repeats after so many periods of the equations.
    multipliers : (n,) complex
        Over that time, largest first; of a coordinate on which nothing depends, as a free base's angle, there is none.
    size : (n,)
        How much each state moves.
    turns : int
        Electrical periods that the rotor is off the command each time; 0 where it follows.
    """

    x: FloatArray
    by_parameter: FloatArray
    periods: int
    multipliers: ComplexArray
    size: FloatArray
    turns: int


def find_orbit(period: PeriodMap, x: FloatArray, most_periods: int = MOTION.most_periods) -> Orbit | None:
    """Return the stable motion that a simulated state tends to, None where none repeats in so many periods at most.

    Raises
    ------
    FitError
        The mechanism diverged.
    """
    for periods in range(1, most_periods + 1):
        found = _newton(period, x, periods)
        if found is not None and abs(found.multipliers).max(initial=0.0) < 1.0:
            return found
    return None


def _newton(period: PeriodMap, x: FloatArray, periods: int) -> Orbit | None:
    start, moved = x, np.inf
    for _ in range(MOTION.iterations):
        image = period(x, periods)
        turns = period.turns_off(image.x - x)
        step = _solved(image, period.modulo(image.x - x)[:, None])[:, 0]
        before, moved = moved, float(np.max(np.abs(step) / image.size))
        if not moved < MOTION.shrinks * before:
            return None
        if moved < MOTION.closed:
            if not _tends(period, start, x, image, periods):
                return None
            by_parameter = _solved(image, image.by_parameter)
            return Orbit(x, by_parameter, periods, multipliers(image.by_state), image.size, turns)
        x = np.where((image.x == 0.0) & (x == 0.0), 0.0, x + step)
    return None


def _solved(image: Image, right: FloatArray) -> FloatArray:
    """Return (I - M)^-1 right, (n, k); of coordinates on which nothing depends the smallest change."""
    scaled = image.by_state * image.size / image.size[:, None]
    moved = np.linalg.lstsq(np.eye(len(right)) - scaled, right / image.size[:, None], rcond=MOTION.neutral)[0]
    return np.asarray(moved * image.size[:, None], dtype=np.float64)


def _tends(period: PeriodMap, start: FloatArray, x: FloatArray, image: Image, periods: int) -> bool:
    """Return whether the simulated start goes towards the fixed point as the linear map at that says.

    It is followed until the linear map leaves little of its distance: Newton's method may have found a motion that is
    stable too, but is another.
    """
    slowest = float(abs(multipliers(image.by_state)).max(initial=MOTION.little))
    times = min(math.ceil(math.log(MOTION.little) / math.log(slowest)), MOTION.most_followed) if slowest < 1.0 else 1
    off = period.modulo(start - x)
    end = period.modulo(period.settled(start, times * periods) - x)
    missed = end - np.linalg.matrix_power(image.by_state, times) @ off
    size = float(np.max(np.abs(off) / image.size))
    return float(np.max(np.abs(missed) / image.size)) <= MOTION.reach * size + MOTION.integrated


def multipliers(by_state: FloatArray) -> ComplexArray:
    """Return the eigenvalues of a period map's derivative, (k,) complex, the largest first.

    A coordinate whose change stays what it is and moves nothing else is left out, and then what only moves such ones.

    Examples
    --------
    >>> multipliers(np.array([[0.5, 0.0, 0.0], [0.0, 1.0, 3.0], [0.0, 0.0, 1.0]]))
    array([0.5+0.j])
    """
    while True:
        neutral = np.max(np.abs(by_state - np.eye(len(by_state))), axis=0, initial=0.0) < MOTION.neutral
        if not neutral.any():
            break
        by_state = by_state[~neutral][:, ~neutral]
    values = np.linalg.eigvals(by_state).astype(np.complex128)
    return np.asarray(values[np.argsort(-np.abs(values))], dtype=np.complex128)
