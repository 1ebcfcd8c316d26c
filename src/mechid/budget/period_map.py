"""The motion over one period of the steps as a map of the state, with its exact derivatives across switches.

At r full steps/s two steps take 2/r. The mechanism is the same after them, with the currents' signs turned (i -> -i),
the rotor 3.6 deg and the load 3.6 deg/G further; after a whole electrical period the rotor may stand any number of
7.2 deg (the load of 7.2 deg/G) elsewhere. States are taken modulo that: a motion that repeats is a fixed point.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mechid.budget.operating_mode import OperatingMode
from mechid.command import RateProfile
from mechid.errors import FitError
from mechid.plant.mechanism import Mechanism
from mechid.simulation.simulator import Run, Simulator, State, TimeBase
from mechid.simulation.trajectory import SimulationOutcome

FloatArray = NDArray[np.float64]

SAMPLE_RATE_HZ = 10_000.0
LOOKS = 16
"""States looked at in a period, for their size."""


@dataclass(frozen=True, eq=False)
class Image:
    """Where a state leads to in some periods.

    Attributes
    ----------
    x : (n,)
        The state then.
    by_state : (n, n)
        Its derivative to the state at the start.
    by_parameter : (n, p)
        Its derivative to the parameters at a fixed start, or along what the start's own were.
    torque : (N,)
        On the way, N m; the last sample is before the period's end.
    gradient : (N, p)
        Derivative of the torque to the parameters.
    size : (n,)
        How much each state moves on the way.
    """

    x: FloatArray
    by_state: FloatArray
    by_parameter: FloatArray
    torque: FloatArray
    gradient: FloatArray
    size: FloatArray


def directions(mechanism: Mechanism, names: Sequence[str]) -> FloatArray:
    """Return what each of these parameters moves of the kernel's, (n_p, p)."""
    slopes, count = mechanism.kernel_jacobian(), mechanism.kernel_values().size
    return np.column_stack([np.zeros((count, 0)), *(slopes[name] for name in names)])


@dataclass(frozen=True, eq=False)
class PeriodMap:
    """A mechanism stepped at one rate.

    Parameters
    ----------
    mechanism : Mechanism
    mode : OperatingMode
    rate : float
        Full steps/s.
    names : tuple of str, (p,)
        Parameters to which derivatives are wanted.
    substeps : int
        Integration steps a sample.
    """

    mechanism: Mechanism
    mode: OperatingMode
    rate: float
    names: tuple[str, ...]
    substeps: int

    @property
    def samples(self) -> int:
        """Of a period of 2/rate: a whole number, so that a line is a bin of the transform over whole periods."""
        return math.ceil(2.0 * SAMPLE_RATE_HZ / self.rate)

    @property
    def sample_rate_hz(self) -> float:
        """Of the samples."""
        return 0.5 * self.samples * self.rate

    @cached_property
    def turn(self) -> FloatArray:
        """By how much each state is further after a period, (n,)."""
        angle = 2.0 * np.pi / self.mechanism.value("stepper.poles")
        further = {"alpha": angle, "alpha_gear": angle / self.mechanism.value("gear.ratio")}
        return np.array([further.get(str(s), 0.0) for s in self.mechanism.plant.states])

    @cached_property
    def sign(self) -> FloatArray:
        """By what each state is multiplied after a period, (n,)."""
        return np.array([-1.0 if str(s).startswith("i_") else 1.0 for s in self.mechanism.plant.states])

    @cached_property
    def _held(self) -> NDArray[np.bool_]:
        """Whether a state may be held at zero by friction, (n,)."""
        switches = self.mechanism.plant.switches
        at_rest = {s for switch in switches for guards in switch.guards.values() for g in guards for s in g.resets}
        return np.array([s in at_rest for s in self.mechanism.plant.states])

    def settled(self, x: FloatArray | None, periods: int) -> FloatArray:
        """Return the state after some periods from a state, or from rest.

        Raises
        ------
        FitError
            The mechanism diverged.
        """
        run = self._run(periods, State(x, np.zeros((x.size, 0))) if x is not None else None, (), 0)
        for _ in run.blocks():
            pass
        self._check(run)
        return self._back(run.state.x, periods)

    def __call__(self, x: FloatArray, periods: int = 1, by_parameter: FloatArray | None = None) -> Image:
        """Return where a state leads to in some periods.

        Raises
        ------
        FitError
            The mechanism diverged.
        """
        n, p = x.size, len(self.names)
        seen = [x]
        lanes = np.hstack([np.zeros((n, p)) if by_parameter is None else by_parameter, np.diag(1.0 - self.pinned(x))])
        run = self._run(periods, State(x, lanes), self.names, n)
        y, J = np.empty(run.base.samples), np.zeros((run.base.samples, p))
        for block in run.blocks():
            y[block.start : block.stop], J[block.start : block.stop] = block.y[:, 0], block.jacobian[:, 0, :p]
            seen.append(run.state.x)
        self._check(run)
        lanes = self.sign[:, None] ** periods * run.state.lanes
        size = np.ptp(np.array(seen), axis=0)
        return Image(
            x=self._back(run.state.x, periods), by_state=lanes[:, p:], by_parameter=lanes[:, :p],
            torque=y[:-1], gradient=J[:-1], size=np.where(size > 0.0, size, 1.0),
        )  # fmt: skip

    def pinned(self, x: FloatArray) -> FloatArray:
        """Return 1 for each state that friction holds, (n,), 0 for the others."""
        return np.asarray(self._held & (x == 0.0), dtype=np.float64)

    def turns_off(self, apart: FloatArray) -> int:
        """Return by how many electrical periods of the rotor two states are apart, as a whole number."""
        at = int(np.argmax(np.abs(self.turn)))
        return round(float(apart[at] / (2.0 * self.turn[at])))

    def modulo(self, apart: FloatArray) -> FloatArray:
        """Return what two states are apart by, (n,), modulo electrical periods."""
        return np.asarray(apart - 2.0 * self.turns_off(apart) * self.turn, dtype=np.float64)

    def simulator(self, samples: int, lanes: int) -> Simulator:
        """Return the simulator of the steps at this rate."""
        command = replace(self.mode.command, rate=RateProfile.constant(self.rate))
        return Simulator(self.mechanism.plant, command, TimeBase(self.sample_rate_hz, samples), capacity=lanes)

    @property
    def lanes(self) -> int:
        """Derivatives that are carried at most."""
        return len(self.names) + len(self.mechanism.plant.states)

    def _run(self, periods: int, start: State | None, names: Sequence[str], state_lanes: int) -> Run:
        simulator = self.simulator(periods * self.samples + 1, self.lanes)
        own = directions(self.mechanism, names)
        lanes = np.hstack([own, np.zeros((len(own), state_lanes))])
        block = math.ceil(self.samples / LOOKS) if state_lanes else None
        run = simulator.run(self.mechanism.kernel_values(), substeps=self.substeps, directions=lanes, block=block)
        if start is not None:
            run.restart(start)
        return run

    def _back(self, x: FloatArray, periods: int) -> FloatArray:
        return np.asarray(self.sign**periods * x - periods * self.turn, dtype=np.float64)

    def _check(self, run: Run) -> None:
        if run.outcome is not SimulationOutcome.COMPLETE:
            raise FitError(f"at {self.rate:.6g} steps/s: {run.outcome.value}")
