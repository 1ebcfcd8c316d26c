"""Search for all steady states of a mode, at rest and by continuation along a rising or falling rate.

With stiction, detents and a resonance the rotor can settle into one of several motions at a rate, depending on how
the rate was reached. Each steady state found is used as a start at both neighbouring rates, until no new one appears.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.incommensurate import map_period
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.orbit import find_orbit
from mechid.budgets.period_map import PeriodMap
from mechid.budgets.settings import MOTION
from mechid.budgets.steady_state import SteadyState, cut_off, enough_substeps, periods_to_settle, steady_state
from mechid.identification.computation.parallel import map_tasks
from mechid.plant.flight import with_line_filter
from mechid.plant.mechanism import Mechanism

FROM_REST, RISING, FALLING = "from rest", "rising", "falling"


@dataclass
class _AtRate:
    """Period map and known steady states at one rate."""

    period: PeriodMap
    known: list[SteadyState] = field(default_factory=list)

    def add(self, found: SteadyState | int, way: str) -> SteadyState | None:
        """Record the way in which a steady state, or a known one by its number, was reached; return it if it is new."""
        for k, other in enumerate(self.known):
            if k == found if isinstance(found, int) else _is_same_motion(self.period, found, other):
                self.known[k] = replace(other, reached=tuple(dict.fromkeys((*other.reached, way))))
                return None
        if isinstance(found, int) or len(self.known) == MOTION.most_motions:
            return None
        self.known.append(replace(found, reached=(way,)))
        return self.known[-1]


def _find_state(task: tuple[_AtRate, FloatArray | None]) -> SteadyState | int:
    """Return the steady state reached from a start at a rate, or its number if it is already known."""
    at, start = task
    p = at.period
    if start is not None:
        x = p.state_after(start, periods_to_settle(p.mode, p.duration_s))
        for k, state in enumerate(at.known):
            if state.periods and _is_on(p, x, state):
                return k
        # Telling a periodic motion from a known endless one needs the orbit search; only its failure identifies x with
        # the latter.
        endless = [k for k, state in enumerate(at.known) if not state.periods]
        if endless and find_orbit(p, x) is None:
            return endless[0]
    return steady_state(p.of_whole.mechanism, p.mode, p.rate, p.names, p.substeps, start)


def steady_states(
    mechanism: Mechanism, mode: OperatingMode, names: Sequence[str], workers: int
) -> tuple[tuple[SteadyState, ...], ...]:
    """Return the steady states at each rate of a mode, the one from rest first.

    On a step clock with a tick no motion repeats, and each rate is run from rest alone.

    Parameters
    ----------
    mechanism : Mechanism
    mode : OperatingMode
    names : sequence of str, (p,)
        Parameters to which the derivatives are wanted; may be empty.
    workers : int
        Threads.

    Raises
    ------
    FitError
        The mechanism diverged.
    """
    substeps = enough_substeps(mechanism, mode, names)
    lined = with_line_filter(mechanism, cut_off(mode))
    rates = [_AtRate(map_period(lined, mode, float(rate), names, substeps)) for rate in mode.rates]
    starts: list[tuple[int, str, FloatArray | None]] = [(k, FROM_REST, None) for k in range(len(rates))]
    while starts:
        tried = map_tasks(_find_state, [(rates[k], x) for k, _, x in starts], workers)
        # Results are added in the order of the tasks, so that their numbers do not depend on the thread that ends
        # first.
        fresh = [(k, rates[k].add(found, way)) for (k, way, _), found in zip(starts, tried, strict=True)]
        # Only new states are continued: every state is tried once in each direction, so that the search ends.
        starts = [
            (k + side, way, state.x)
            for k, state in fresh
            for side, way in ((1, RISING), (-1, FALLING))
            if state is not None and 0 <= k + side < len(rates) and not mode.command.clock_tick_s
        ]
    return tuple(tuple(at.known) for at in rates)


def _is_same_motion(period: PeriodMap, state: SteadyState, other: SteadyState) -> bool:
    """Return whether two steady states coincide; motions that do not repeat are not distinguished."""
    return state.periods == other.periods and (state.periods == 0 or _is_on(period, state.x, other))


def _is_on(period: PeriodMap, x: FloatArray, state: SteadyState) -> bool:
    """Return whether a state lies on a repeating motion, that is, on one of its states after each period."""
    passed = state.x
    for k in range(state.periods):
        passed = period.state_after(passed, 1) if k else passed
        if float(np.max(np.abs(period.modulo(x - passed)) / state.size)) < MOTION.same_motion:
            return True
    return False
