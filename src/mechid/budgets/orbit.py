"""Periodic orbits by shooting: Newton's method on the period map, and Floquet multipliers.

With F the map over m periods and M = dF/dx at its fixed point x*, a deviation is multiplied by M in that time: the
eigenvalues of M are the Floquet multipliers, and the orbit is stable if all lie inside the unit circle. The derivative
of the fixed point with respect to the parameters is (I - M)^-1 F_p, also where transients decay slowly.
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
    """Motion that repeats.

    Attributes
    ----------
    x : (n,)
        State at its start.
    by_parameter : (n, p)
        Derivative of that state with respect to the parameters.
    periods : int
        Number of periods of the equations after which it repeats.
    multipliers : (n,) complex
        Over that time, largest first; without those of cyclic coordinates such as a free base's angle.
    size : (n,)
        Range of each state.
    turns : int
        Electrical periods that the rotor slips per repetition; 0 if it follows the command.
    """

    x: FloatArray
    by_parameter: FloatArray
    periods: int
    multipliers: ComplexArray
    size: FloatArray
    turns: int


def find_orbit(period: PeriodMap, x: FloatArray, most_periods: int = MOTION.most_periods) -> Orbit | None:
    """Return the stable orbit that a simulated state approaches, None if none repeats within `most_periods`.

    Raises
    ------
    FitError
        The mechanism diverged.
    """
    # The shortest period first: a motion of period m is also one of period 2 m.
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
        step = _solve(image, period.modulo(image.x - x)[:, None])[:, 0]
        before, moved = moved, float(np.max(np.abs(step) / image.size))
        # Written so that NaN also ends the iteration.
        if not moved < MOTION.shrinks * before:
            return None
        if moved < MOTION.closed:
            if not _approaches(period, start, x, image, periods):
                return None
            by_parameter = _solve(image, image.by_parameter)
            return Orbit(x, by_parameter, periods, multipliers(image.by_state), image.size, turns)
        # A state that friction holds at exactly zero stays there: a Newton step would release it.
        x = np.where((image.x == 0.0) & (x == 0.0), 0.0, x + step)
    return None


def _solve(image: Image, right: FloatArray) -> FloatArray:
    """Return (I - M)^-1 right, (n, k); in neutral directions the solution of least norm."""
    # States have different units; scaled by their range, one tolerance serves all of them.
    scaled = image.by_state * image.size / image.size[:, None]
    moved = np.linalg.lstsq(np.eye(len(right)) - scaled, right / image.size[:, None], rcond=MOTION.neutral)[0]
    return np.asarray(moved * image.size[:, None], dtype=np.float64)


def _approaches(period: PeriodMap, start: FloatArray, x: FloatArray, image: Image, periods: int) -> bool:
    """Return whether the simulated start approaches the fixed point as the linear map predicts.

    The simulation continues until the linear map leaves little of the distance: Newton's method may have converged to
    another stable orbit.
    """
    # At least `little`, so that the logarithm is finite if all multipliers vanish.
    slowest = float(abs(multipliers(image.by_state)).max(initial=MOTION.little))
    times = min(math.ceil(math.log(MOTION.little) / math.log(slowest)), MOTION.most_followed) if slowest < 1.0 else 1
    off = period.modulo(start - x)
    end = period.modulo(period.state_after(start, times * periods) - x)
    missed = end - np.linalg.matrix_power(image.by_state, times) @ off
    size = float(np.max(np.abs(off) / image.size))
    return float(np.max(np.abs(missed) / image.size)) <= MOTION.reach * size + MOTION.integrated


def multipliers(by_state: FloatArray) -> ComplexArray:
    """Return the eigenvalues of a period map's derivative, (k,) complex, the largest first.

    Neutral coordinates, which keep their deviation and move nothing else, are removed, and then those that move only
    neutral ones.

    Examples
    --------
    >>> multipliers(np.array([[0.5, 0.0, 0.0], [0.0, 1.0, 3.0], [0.0, 0.0, 1.0]]))
    array([0.5+0.j])
    """
    while True:
        # Repeated, since coordinates that moved only neutral ones become neutral once these are removed.
        neutral = np.max(np.abs(by_state - np.eye(len(by_state))), axis=0, initial=0.0) < MOTION.neutral
        if not neutral.any():
            break
        by_state = by_state[~neutral][:, ~neutral]
    values = np.linalg.eigvals(by_state).astype(np.complex128)
    return np.asarray(values[np.argsort(-np.abs(values))], dtype=np.complex128)
