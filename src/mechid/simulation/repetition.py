"""Number of full steps after which the motion of a stepped mechanism may repeat, found from its equations.

After two full steps the commanded voltages have changed sign; after four they are the same (with three phases after
three and six, and d below is pi/3). A motion can repeat after n steps, n even, if the equations are invariant under

    x -> sigma x + n d,   d = pi/2 d(x at the start)/d(theta_0),

with sigma = -1 for the states that the inputs set at the start (the currents) where n/2 is odd, else 1. The paper's
mechanism repeats after n = 2. A detent with one period per electrical period, unequal offsets of the phases or an even
harmonic of the torque constant require n = 4; a gear error that repeats with the rotor's turn requires n = 2 p.
The equations are compared at random points, so that no block needs to declare anything.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from mechid.arrays import BoolArray, FloatArray
from mechid.plant.mechanism import Mechanism
from mechid.plant.plant import Plant

Function = Callable[[Sequence[float], Sequence[float], Sequence[float], Sequence[float]], list[float]]

MIRRORED = 2
"""Full steps of two or four phases after which the voltages have the opposite sign; three phases need three."""
MOST_STEPS = 2000
"""Largest number of steps tried: ten turns of a motor of 200 steps."""
POINTS = 4
SAME = 1e-8
"""Relative difference attributed to rounding."""


@dataclass(frozen=True, eq=False)
class Repetition:
    """Symmetry under which a motion may repeat.

    Attributes
    ----------
    steps : int
        Smallest number of full steps of a repetition; 0 if the equations do not repeat within `MOST_STEPS`.
    sign : (n,)
        Factor on each state over these steps.
    turn : (n,)
        Increment of each state over these steps.
    whole : (n,)
        Shift of the states that leaves everything unchanged, all signs included.
    electrical : (n,)
        Increment of each state over an electrical period.
    """

    steps: int
    sign: FloatArray
    turn: FloatArray
    whole: FloatArray
    electrical: FloatArray


def repetition(mechanism: Mechanism, most_steps: float = MOST_STEPS, voltages: int | None = None) -> Repetition:
    """Return how the motion of a stepped mechanism may repeat within a number of full steps.

    Parameters
    ----------
    mechanism : Mechanism
    most_steps : float
        Longest repetition, in full steps.
    voltages : {2, 4, 3, 6} or None
        Full steps after which the voltages have the opposite sign; or, if no half period of them mirrors the other,
        are the same (`Command.mirrored_steps`). None is half an electrical period.
    """
    electrical = mechanism.full_steps
    voltages = voltages or electrical // 2
    steps, a_step, odd = _find_repetition(mechanism.plant, mechanism.kernel_values().tobytes(), electrical)
    steps = math.lcm(steps, voltages)
    steps = steps if steps <= most_steps else 0
    period = steps or voltages
    mirrored = period % electrical != 0
    return Repetition(
        steps=steps,
        sign=np.where(odd & mirrored, -1.0, 1.0),
        turn=period * a_step,
        whole=(2 if mirrored else 1) * period * a_step,
        electrical=electrical * a_step,
    )


@lru_cache(maxsize=256)
def _find_repetition(plant: Plant, values: bytes, electrical: int) -> tuple[int, FloatArray, BoolArray]:
    """Return the smallest number of steps after which the equations are the same, or 0.

    Also return the increment of each state over a step, and whether the sign of each state may change.
    """
    p = np.frombuffer(values, dtype=np.float64)
    a_step, odd, half = _step_increment(plant, p, electrical), _is_set_by_inputs(plant), electrical // 2
    tester = _Tester(_compile_equations(plant), p, a_step, np.where(odd, -1.0, 1.0), plant, electrical)
    return next((n for n in range(half, MOST_STEPS + 1, half) if tester.is_same_after(n)), 0), a_step, odd


def _is_set_by_inputs(plant: Plant) -> BoolArray:
    """Return which states the inputs set at the start, (n,)."""
    return np.array([bool(sp.sympify(e).free_symbols & set(plant.inputs)) for e in plant.initial])


@dataclass(frozen=True, eq=False)
class _Tester:
    """Comparison of the equations at random points with those at the transformed points."""

    function: Function
    p: FloatArray
    a_step: FloatArray
    sign: FloatArray
    plant: Plant
    electrical: int

    def is_same_after(self, steps: int) -> bool:
        """Return whether the equations are the same after a number of steps; the first point that differs decides."""
        # A fixed seed: the verdict on a mechanism must not change from run to run.
        rng = np.random.default_rng(0)
        return all(self._is_same_at(rng, steps) for _ in range(POINTS))

    def _is_same_at(self, rng: np.random.Generator, steps: int) -> bool:
        x, u = rng.uniform(-1.0, 1.0, self.a_step.size), rng.uniform(-1.0, 1.0, len(self.plant.inputs))
        drawn = (rng.choice([list(mode.values()) for mode in s.modes.values()]) for s in self.plant.switches)
        modes = [float(value) for values in drawn for value in values]
        mirrored = steps % self.electrical != 0
        sign = self.sign if mirrored else np.ones_like(self.sign)
        here = self._at(x, u, modes)
        there = self._at(sign * x + steps * self.a_step, -u if mirrored else u, modes)
        n = x.size
        there[:n] *= sign
        # The median magnitude keeps rounding in terms that are nearly zero from counting as a difference.
        scale = np.abs(here) + np.abs(there) + float(np.median(np.abs(here)))
        return bool(np.all(np.abs(there - here) <= SAME * scale))

    def _at(self, x: FloatArray, u: FloatArray, modes: Sequence[float]) -> FloatArray:
        return np.array(self.function(x.tolist(), u.tolist(), modes, self.p.tolist()), dtype=np.float64)


def _step_increment(plant: Plant, p: FloatArray, electrical: int) -> FloatArray:
    """Return the increment of each state over a full step, (n,)."""
    by_value = dict(zip(plant.parameters, p.tolist(), strict=True))
    turned = [plant.start_angle_slopes.get(s, sp.Integer(0)) for s in plant.states]
    # A full step is a quarter of an electrical period, a sixth with three phases.
    return np.array([2.0 * np.pi / electrical * float(slope.subs(by_value)) for slope in turned])


@lru_cache(maxsize=32)
def _compile_equations(plant: Plant) -> Function:
    """Compile all terms that determine a motion and its torque: rates, margins, entry rules, filter inputs, torque."""
    margins = [g.margin for s in plant.switches for guards in s.guards.values() for g in guards]
    entries = [e for s in plant.switches for e, _ in s.entry]
    modes = tuple(m for s in plant.switches for m in next(iter(s.modes.values())))
    # A linear filter behind the plant repeats if its inputs do, so its own states are left out.
    torque = plant.expand(sp.sympify(plant.outputs["torque"])).subs(dict.fromkeys(plant.filter.states, 0))
    decisive = (*plant.rates, *margins, *entries, *plant.filter.inputs, torque)
    every = [plant.expand(sp.sympify(e)) for e in decisive]
    compiled: Function = sp.lambdify((plant.states, plant.inputs, modes, plant.parameters), every, "math", cse=True)
    return compiled
