"""The slow twin of the generated kernel: the same plant by SciPy's DOP853, written to be obvious.

The plant's terms are folded in, filter states are plain states, every function is lambdified. The
twin goes from edge to edge; on the way it looks for the first guard that reaches zero, and for
sensitivities it carries the variational equations S' = f_s S + f_p as one more part of the state.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import DOP853, DenseOutput
from scipy.optimize import brentq, minimize_scalar

from mechid.command import Excitation
from mechid.kernel.equations import Equations, FloatArray, equations_of
from mechid.plant.plant import Plant

CHECKS = 16
"""So many times in each step of the integrator the guards are looked at."""
ABSOLUTE = 1e-3
"""Absolute tolerance over relative one: the gear's angle is some 1e-3 rad and feeds K_s = 1e3 N m/rad."""

Fired = tuple[int, int]
"""Switch and guard (in the order of its mode's guards) that reached zero."""


@dataclass(frozen=True, kw_only=True)
class TwinState:
    """Where a run stands.

    Attributes
    ----------
    time : float
        Command time in s.
    s : (n,) array
        States of the plant, then of its filter, SI units.
    S : (n, m) array
        Their derivatives to the sensitive parameters.
    inputs : (i,) array
        Excitation.
    modes : tuple of int
        Mode of each switch.
    armed : tuple of tuple of bool
        For each guard of those modes, whether it has stood above zero since the mode began.
    """

    time: float
    s: FloatArray
    S: FloatArray
    inputs: FloatArray
    modes: tuple[int, ...]
    armed: tuple[tuple[bool, ...], ...]


@dataclass(frozen=True, kw_only=True)
class TwinSwitch:
    """One switch: its instant in s and that instant's derivatives (m,), modes before and after."""

    time: float
    switch: int
    before: int
    after: int
    sensitivity: FloatArray


@dataclass(frozen=True, kw_only=True)
class TwinRun:
    """What a run returns: y and rate = dy/dt (n, n_y), jacobian (n, n_y, m), switches, last state."""

    y: FloatArray
    rate: FloatArray
    jacobian: FloatArray
    switching: tuple[TwinSwitch, ...]
    end: TwinState


def simulate_twin(
    plant: Plant,
    excitation: Excitation,
    times: ArrayLike,
    p: ArrayLike,
    *,
    start_angle_rad: float = 0.0,
    begin: TwinState | None = None,
    sensitive: Sequence[int] = (),
    tolerance: float = 1e-10,
) -> TwinRun:
    """Simulate a plant at uniform sample instants.

    Where an output jumps within a sample interval, its sample is the jump's mean over it.

    Parameters
    ----------
    plant : Plant
    excitation : Excitation
    times : (n,) array
        Two sample instants or more, s of command time; before 0 the mechanism rests.
    p : (n_p,) array
        The kernel's parameters.
    start_angle_rad : float
        Electrical angle theta_0 at the start of the record.
    begin : TwinState, optional
        Start from here instead, before or at the first sample.
    sensitive : sequence of int
        Indices of the parameters to which derivatives are wanted.
    tolerance : float
        Relative tolerance of one step of the integrator.
    """
    twin = Twin(equations_of(plant), np.asarray(p, dtype=np.float64), tuple(sensitive), tolerance)
    state = begin or twin.start(excitation.initial, start_angle_rad)
    samples = _Samples(twin, np.asarray(times, dtype=np.float64), state.time)
    switching: list[TwinSwitch] = []
    for inputs, end in _stretches(excitation, state, float(samples.times[-1])):
        state, fired = twin.arc(replace(state, inputs=inputs), end, samples)
        while fired is not None:
            before, (state, switch) = state, twin.switched(state, *fired)
            samples.jump(before, state, switch)
            switching.append(switch)
            state, fired = twin.arc(state, end, samples)
    y, rate, J = samples.finished()
    return TwinRun(y=y, rate=rate, jacobian=J, switching=tuple(switching), end=state)


def _stretches(excitation: Excitation, state: TwinState, end: float) -> Iterator[tuple[FloatArray, float]]:
    """Yield the inputs between edges, from where a run stands, and the instant up to which they hold."""
    inputs = state.inputs
    for time, values in zip(excitation.times, excitation.values, strict=True):
        if state.time < time < end:
            yield inputs, float(time)
        if state.time < time:
            inputs = values
        if time >= end:
            return
    yield inputs, end
