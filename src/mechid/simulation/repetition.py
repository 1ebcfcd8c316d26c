"""After how many full steps a stepped mechanism may repeat: found in its own equations.

After two full steps the commanded voltages have changed sign; after four they are the same. A motion can repeat after n
steps, n even, if the equations do not tell x from

    x -> sigma x + n d,   d = pi/2 d(x at the start)/d(theta_0),

with sigma = -1 for the states that the inputs make at the start (the currents) where n/2 is odd, else 1. So it is for
n = 2 in the paper's mechanism; a detent of one period in an electrical period, unlike offsets of the phases or an even
harmonic of the torque constant ask for n = 4, an error of the gear that repeats with the rotor's turn for n = 2 p.
The equations are compared at random points, so that no block needs to declare anything.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from mechid.arrays import BoolArray, FloatArray
from mechid.plant.mechanism import Mechanism
from mechid.plant.plant import Plant

Function = Callable[[Sequence[float], Sequence[float], Sequence[float], Sequence[float]], list[float]]

MIRRORED, ELECTRICAL = 2, 4
"""Full steps after which the voltages have the other sign, and after which they are the same."""
MOST_STEPS = 2000
"""Steps that are tried: ten turns of a motor of 200 steps."""
POINTS = 4
SAME = 1e-8
"""Relative difference that is rounding."""


@dataclass(frozen=True, eq=False)
class Repetition:
    """How a motion may repeat.

    Attributes
    ----------
    steps : int
        After so many full steps at the earliest; 0 where the equations never come back within `MOST_STEPS`.
    sign : (n,)
        By what each state is multiplied over them.
    turn : (n,)
        How much further each state then is.
    whole : (n,)
        By how much states may be shifted without any change, with all signs as they were.
    electrical : (n,)
        How much further each state is after an electrical period.
    """

    steps: int
    sign: FloatArray
    turn: FloatArray
    whole: FloatArray
    electrical: FloatArray


def repetition(mechanism: Mechanism, most_steps: float = MOST_STEPS) -> Repetition:
    """Return how the motion of a stepped mechanism may repeat, within so many full steps."""
    steps, a_step, odd = _found(mechanism.plant, mechanism.kernel_values().tobytes())
    steps = steps if steps <= most_steps else 0
    period = steps or MIRRORED
    mirrored = period % ELECTRICAL != 0
    return Repetition(
        steps=steps,
        sign=np.where(odd & mirrored, -1.0, 1.0),
        turn=period * a_step,
        whole=(2 if mirrored else 1) * period * a_step,
        electrical=ELECTRICAL * a_step,
    )


@lru_cache(maxsize=256)
def _found(plant: Plant, values: bytes) -> tuple[int, FloatArray, BoolArray]:
    """Return the least number of steps after which the equations are the same, 0 where there is none.

    With it, how much further each state is after a step, and whether its sign may turn: all rates of a mode ask.
    """
    p = np.frombuffer(values, dtype=np.float64)
    a_step, odd = _turned(plant, p), _odd(plant)
    tester = _Tester(_compared(plant), p, a_step, np.where(odd, -1.0, 1.0), plant)
    return next((n for n in range(MIRRORED, MOST_STEPS + 1, MIRRORED) if tester.same(n)), 0), a_step, odd


def _odd(plant: Plant) -> BoolArray:
    """Return which states the inputs make at the start, (n,)."""
    return np.array([bool(sp.sympify(e).free_symbols & set(plant.inputs)) for e in plant.initial])


@dataclass(frozen=True, eq=False)
class _Tester:
    """The equations at random points, and at what these become after some steps."""

    function: Function
    p: FloatArray
    a_step: FloatArray
    sign: FloatArray
    plant: Plant

    def same(self, steps: int) -> bool:
        """Return whether the equations are the same after so many steps; a point that tells them apart ends it."""
        rng = np.random.default_rng(0)
        return all(self._same_at(rng, steps) for _ in range(POINTS))

    def _same_at(self, rng: np.random.Generator, steps: int) -> bool:
        x, u = rng.uniform(-1.0, 1.0, self.a_step.size), rng.uniform(-1.0, 1.0, len(self.plant.inputs))
        drawn = (rng.choice([list(mode.values()) for mode in s.modes.values()]) for s in self.plant.switches)
        modes = [float(value) for values in drawn for value in values]
        mirrored = steps % ELECTRICAL != 0
        sign = self.sign if mirrored else np.ones_like(self.sign)
        here = self._at(x, u, modes)
        there = self._at(sign * x + steps * self.a_step, -u if mirrored else u, modes)
        n = x.size
        there[:n] *= sign
        scale = np.abs(here) + np.abs(there) + float(np.median(np.abs(here)))
        return bool(np.all(np.abs(there - here) <= SAME * scale))

    def _at(self, x: FloatArray, u: FloatArray, modes: Sequence[float]) -> FloatArray:
        return np.array(self.function(x.tolist(), u.tolist(), modes, self.p.tolist()), dtype=np.float64)


def _turned(plant: Plant, p: FloatArray) -> FloatArray:
    """Return how much further each state is after a full step, (n,)."""
    by_value = dict(zip(plant.parameters, p.tolist(), strict=True))
    turned = [plant.turned.get(s, sp.Integer(0)) for s in plant.states]
    return np.array([0.5 * np.pi * float(slope.subs(by_value)) for slope in turned])


@lru_cache(maxsize=32)
def _compared(plant: Plant) -> Function:
    """Compile all that decides a motion and its torque: rates, margins, entry rules, filter inputs, the torque."""
    margins = [g.margin for s in plant.switches for guards in s.guards.values() for g in guards]
    entries = [e for s in plant.switches for e, _ in s.entry]
    modes = tuple(m for s in plant.switches for m in next(iter(s.modes.values())))
    # A linear filter behind the plant repeats where what feeds it does: its own states are left out.
    torque = plant.expand(sp.sympify(plant.outputs["torque"])).subs(dict.fromkeys(plant.filter.states, 0))
    decisive = (*plant.rates, *margins, *entries, *plant.filter.inputs, torque)
    every = [plant.expand(sp.sympify(e)) for e in decisive]
    compiled: Function = sp.lambdify((plant.states, plant.inputs, modes, plant.parameters), every, "math", cse=True)
    return compiled
