"""Loops closed sample by sample around the nonlinear equations, and their response to a sine.

A sine is added to the output of the controller whose loop is measured. The controllers compute at their samples from
the nonlinear outputs, their results act after the delay, and the equations are integrated in between. With u the sum of
the sine and the controller's output c, the open loop is L = -C/U at the frequency of the sine. The run starts on the
linear response, so that only what departs from it settles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.exports.linear.linearisation import HeldMechanism
from mechid.exports.linear.loops.closing import CURRENTS, QUADRATURE, Loop
from mechid.exports.linear.loops.loop_file import LoopDesign, SampledTiming
from mechid.exports.linear.loops.sampled import ROUNDING, Sampled, split_delay
from mechid.exports.linear.state_space import LinearModel
from mechid.kernel.equations import equations_of
from mechid.simulation.linearisation import Linearised

STEP = 0.15
"""Integration step, as a share of the reciprocal of the fastest eigenvalue."""


@dataclass(frozen=True, eq=False)
class NonlinearPlant:
    """Nonlinear equations of a holding mechanism, driven by voltages or currents added in its phases.

    Attributes
    ----------
    held : HeldMechanism
    model : LinearModel
        Linear model of the same holding condition.
    """

    held: HeldMechanism
    model: LinearModel

    @cached_property
    def about(self) -> Linearised:
        """Rest point and modes of the switches."""
        return self.held.about(self.model.name)

    @cached_property
    def moving_states(self) -> list[int]:
        """Indices of the model's states."""
        return self.held.moving_states(self.model.name)

    @cached_property
    def columns(self) -> list[int]:
        """Indices of the phases' inputs among those of the plant."""
        return self.held.columns[:2]

    def outputs(self, x: FloatArray) -> FloatArray:
        """Return the deviations of the outputs, in the order of the model without its acceleration."""
        rest, equations = self.held.rest(self.about), equations_of(self.held.plant)
        found = equations.outputs(x.tolist(), self.about.inputs.tolist(), *rest)
        return np.asarray(found - self.model.y[: found.size], dtype=np.float64)

    def advance(self, x: FloatArray, added: FloatArray, time_s: float) -> FloatArray:
        """Integrate the states over a time with constant phase inputs, by Runge-Kutta steps of fourth order."""
        count = max(math.ceil(time_s * self._fastest / STEP), 1)
        h, rest, rates = time_s / count, self.held.rest(self.about), equations_of(self.held.plant).rates
        u = self.about.inputs.copy()
        u[self.columns] += added
        inputs = u.tolist()
        for _ in range(count):
            k1 = rates(x.tolist(), inputs, *rest)
            k2 = rates((x + 0.5 * h * k1).tolist(), inputs, *rest)
            k3 = rates((x + 0.5 * h * k2).tolist(), inputs, *rest)
            k4 = rates((x + h * k3).tolist(), inputs, *rest)
            x = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        return x

    @cached_property
    def _fastest(self) -> float:
        return float(np.abs(np.linalg.eigvals(self.model.matrices.A)).max(initial=1.0))


class Electronics:
    """Controllers, delays and holds of a design, with their states."""

    def __init__(self, design: LoopDesign, timing: SampledTiming, every: int, late: int) -> None:
        self.current = design.current
        self.whole, self.fraction = split_delay(timing.delay_s / timing.period_s)
        self.period_s, self.every, self.late = timing.period_s, every, late
        self.sums = np.zeros(2)
        self.past = np.zeros((self.whole + (self.fraction > 0.0), 2))
        self.references = np.zeros((late // every + 1 + (late % every > 0), 2))
        self.position: Sampled | None = None
        self.x = np.zeros(0)

    def take_state(self, state: FloatArray, controller: Sampled | None) -> None:
        """Begin at the state of the linear closed loop, behind the states of its plant."""
        self.past, state = state[: self.past.size].reshape(-1, 2).copy(), state[self.past.size :]
        if self.current:
            self.sums, state = state[:2].copy(), state[2:]
        if controller is not None:
            self.position, size = controller, len(controller.matrices.A)
            earlier = state[: len(state) - size].reshape(-1, 2)
            if earlier.size:
                self.references[: len(earlier)] = earlier
            self.x = state[len(state) - size :].copy()

    def control_position(self, angle: float, added: float, along: FloatArray) -> float:
        """Compute the position controller, shift its command into the delay, and return its output."""
        assert self.position is not None
        A, B, C, D = self.position.matrices.all
        out = float((C @ self.x + D[:, 0] * -angle)[0])
        self.x = A @ self.x + B[:, 0] * -angle
        self.references[1:] = self.references[:-1]
        self.references[0] = (out + added) * along
        return out

    def reference(self, k: int) -> FloatArray:
        """Return the command that has arrived at a base sample, counted from that of the last position sample."""
        return np.asarray(self.references[-((k - self.late) // self.every)])

    def control_currents(self, error: FloatArray) -> FloatArray:
        """Return the outputs of the PI controllers, (2,)."""
        assert self.current is not None
        self.sums = self.sums + self.current.ki * self.period_s * error
        return np.asarray(self.current.kp * error + self.sums)

    def act(self, plant: NonlinearPlant, x: FloatArray, command: FloatArray) -> FloatArray:
        """Integrate the plant until the next sample, while delayed commands act."""
        stages = np.concatenate([command[None], self.past])
        late_s = self.fraction * self.period_s
        if late_s > 0.0:
            x = plant.advance(x, stages[self.whole + 1], late_s)
        x = plant.advance(x, stages[self.whole], self.period_s - late_s)
        self.past = stages[: len(self.past)]
        return x


def measure_loop(
    plant: NonlinearPlant, design: LoopDesign, loop: Loop, driven: str, cycles: int, samples: int, share: float
) -> complex:
    """Return the open loop at a frequency from a run of the nonlinear equations.

    Parameters
    ----------
    plant : NonlinearPlant
    design : LoopDesign
    loop : Loop
        The linear loop, closed.
    driven : str
        Input to which the sine is added: a phase's, or the quadrature command.
    cycles, samples : int
        Whole cycles of the sine in so many samples of the loop.
    share : float
        Amplitude of the largest current, relative to the held current.
    """
    w = 2.0 * np.pi * cycles / samples
    state, outputs = _linear_response(loop.closed, driven, w)
    size = share * _held_current(plant) / max(np.abs(outputs).max(initial=0.0), 1e-300)
    of_position = driven == QUADRATURE
    electronics, every = _electronics(design, of_position)
    n = len(plant.moving_states)
    x = plant.about.x.copy()
    x[plant.moving_states] += size * state[:n].real
    electronics.take_state(size * state[n:].real, loop.controller if of_position else None)
    added, given = size * np.cos(w * np.arange(samples)), np.empty(samples)
    names = plant.model.outputs.names
    rows = [names.index(name) for name in CURRENTS]
    sensor = names.index(design.position.sensor) if design.position and of_position else 0
    angle = plant.held.command.start_angle_rad
    along = np.array([math.sin(angle), math.cos(angle)])
    place = None if of_position else plant.model.inputs.names.index(driven)
    for k in range(samples * every):
        y = plant.outputs(x)
        if of_position and k % every == 0:
            given[k // every] = electronics.control_position(y[sensor], added[k // every], along)
        reference = electronics.reference(k % every) if of_position else np.zeros(2)
        command = electronics.control_currents(reference - y[rows]) if design.current else reference
        if place is not None:
            given[k] = command[place]
            command[place] += added[k]
        x = electronics.act(plant, x, command)
    turning = np.exp(-1j * w * np.arange(samples))
    return complex(-(given @ turning) / ((given + added) @ turning))


def _linear_response(closed: Sampled, driven: str, w: float) -> tuple[ComplexArray, ComplexArray]:
    """Return states and phase currents of a closed loop under a unit sine."""
    A, B, C, D = closed.matrices.all
    column = closed.inputs.index(driven)
    shifted = np.exp(1j * w) * np.eye(len(A)) - A
    state = np.asarray(np.linalg.solve(shifted, B[:, column] + 0j), dtype=np.complex128)
    rows = [closed.outputs.index(name) for name in CURRENTS]
    return state, np.asarray(C[rows] @ state + D[rows, column], dtype=np.complex128)


def _held_current(plant: NonlinearPlant) -> float:
    names = plant.model.outputs.names
    return float(np.linalg.norm([plant.model.y[names.index(name)] for name in CURRENTS]))


def _electronics(design: LoopDesign, of_position: bool) -> tuple[Electronics, int]:
    """Return the electronics at their fastest rate, and that rate over the rate of the measured loop."""
    if design.current is None:
        assert design.position is not None
        return Electronics(design, design.position.timing, 1, 0), 1
    timing = design.current.timing
    if not of_position or design.position is None:
        return Electronics(design, timing, 1, 0), 1
    every = round(design.position.timing.period_s / timing.period_s)
    late = math.ceil(design.position.timing.delay_s / timing.period_s - ROUNDING)
    return Electronics(design, timing, every, late), every
