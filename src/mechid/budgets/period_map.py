"""The motion over one period of the steps as a map of the state, with its exact derivatives across switches.

After n full steps, n/r at r full steps/s, the mechanism is the same but for a sign and a turn of its states, which
`simulation.repetition` finds: of the paper's after two steps with the currents' signs turned (i -> -i), the rotor
3.6 deg and the load 3.6 deg/G further, and the rotor may stand any number of 7.2 deg (the load of 7.2 deg/G) elsewhere.
States are taken modulo that: a motion that repeats is a fixed point.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.settings import MOTION
from mechid.command import RateProfile
from mechid.errors import FitError
from mechid.plant.mechanism import Mechanism
from mechid.simulation.block import State
from mechid.simulation.repetition import MIRRORED, Repetition, repetition
from mechid.simulation.simulator import Run, Simulator, TimeBase
from mechid.simulation.trajectory import SimulationOutcome


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
    size : (n,)
        How much each state moves on the way.
    """

    x: FloatArray
    by_state: FloatArray
    by_parameter: FloatArray
    size: FloatArray


@dataclass(frozen=True, eq=False)
class Stretch:
    """The torque over some periods.

    Attributes
    ----------
    torque : (N,)
        N m; the last sample is before the last period's end.
    below : (N, 1 + p)
        The torque behind the filter before its lines, then its derivatives to the parameters.
    """

    torque: FloatArray
    below: FloatArray


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
        In flight; `plant.flight.with_line_filter` makes it give its torque below a cut-off too.
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

    @cached_property
    def repetition(self) -> Repetition:
        """How the motion may repeat within a time that is worth a look."""
        return repetition(self.mechanism, MOTION.longest_s * self.rate)

    @property
    def repeats(self) -> bool:
        """Whether the motion may repeat; on a step clock with a tick none does."""
        return bool(self.repetition.steps) and not self.mode.command.clock_tick_s

    @property
    def steps(self) -> int:
        """Full steps in a period; of a motion that cannot repeat those after which the voltages do."""
        return self.repetition.steps or MIRRORED

    @property
    def duration_s(self) -> float:
        """Of a period."""
        return self.steps / self.rate

    @property
    def samples(self) -> int:
        """Of a period: a whole number for each step, so that lines are bins and all step edges fall on samples."""
        each = self.steps * self.mode.command.steps_per_full_step
        wanted = max(MOTION.sample_rate_hz, MOTION.above_cut_off * self.mode.highest_hz) * self.duration_s
        return each * math.ceil(wanted / each)

    @property
    def sample_rate_hz(self) -> float:
        """Of the samples."""
        return self.samples / self.duration_s

    @cached_property
    def _held(self) -> BoolArray:
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
        for _ in run.blocks():
            seen.append(run.state.x)
        self._check(run)
        lanes = self.repetition.sign[:, None] ** periods * run.state.lanes
        size = np.ptp(np.array(seen), axis=0)
        return Image(
            x=self._back(run.state.x, periods),
            by_state=lanes[:, p:],
            by_parameter=lanes[:, :p],
            size=np.where(size > 0.0, size, 1.0),
        )

    def stretch(
        self, start: State | None, skipped: int, periods: int, *, slopes: bool = True, finer: int = 1
    ) -> Stretch:
        """Return the torque over some periods behind others, from a state or from rest.

        Parameters
        ----------
        start : State or None
            Its lanes are derivatives to the parameters; none where there are no slopes.
        skipped, periods : int
        slopes : bool
            Whether derivatives to the parameters are wanted.
        finer : int
            So many times the samples of a period, and so many times the steps.

        Raises
        ------
        FitError
            The mechanism diverged.
        """
        n = finer * self.samples
        simulator = self.simulator((skipped + periods) * n + 1, self.lanes, finer)
        own = directions(self.mechanism, self.names if slopes else ())
        run = simulator.run(self.mechanism.kernel_values(), substeps=self.substeps, directions=own)
        if start is not None:
            run.restart(start)
        torque, below, first = np.empty(periods * n), np.empty((periods * n, 1 + own.shape[1])), skipped * n
        for block in run.blocks():
            rows = slice(max(block.start - first, 0), min(block.stop - first, periods * n))
            if rows.stop > rows.start:
                here = slice(rows.start + first - block.start, rows.stop + first - block.start)
                torque[rows], below[rows, 0] = block.y[here, 0], block.y[here, 1]
                if own.shape[1]:
                    below[rows, 1:] = block.jacobian[here, 1, : own.shape[1]]
        self._check(run)
        return Stretch(torque, below)

    def pinned(self, x: FloatArray) -> FloatArray:
        """Return 1 for each state that friction holds, (n,), 0 for the others."""
        return np.asarray(self._held & (x == 0.0), dtype=np.float64)

    def turns_off(self, apart: FloatArray) -> int:
        """Return by how many electrical periods of the rotor two states are apart, as a whole number."""
        return _times(apart, self.repetition.electrical)

    def modulo(self, apart: FloatArray) -> FloatArray:
        """Return what two states are apart by, (n,), modulo the shifts that change nothing."""
        return np.asarray(apart - _times(apart, self.repetition.whole) * self.repetition.whole, dtype=np.float64)

    def simulator(self, samples: int, lanes: int, finer: int = 1) -> Simulator:
        """Return the simulator of the steps at this rate, sampled so many times finer."""
        command = replace(self.mode.command, rate=RateProfile.constant(self.rate))
        return Simulator(self.mechanism.plant, command, TimeBase(finer * self.sample_rate_hz, samples), capacity=lanes)

    @property
    def lanes(self) -> int:
        """Derivatives that are carried at most."""
        return len(self.names) + len(self.mechanism.plant.states)

    def _run(self, periods: int, start: State | None, names: Sequence[str], state_lanes: int) -> Run:
        simulator = self.simulator(periods * self.samples + 1, self.lanes)
        own = directions(self.mechanism, names)
        lanes = np.hstack([own, np.zeros((len(own), state_lanes))])
        block = math.ceil(self.samples / MOTION.looks) if state_lanes else None
        run = simulator.run(self.mechanism.kernel_values(), substeps=self.substeps, directions=lanes, block=block)
        if start is not None:
            run.restart(start)
        return run

    def _back(self, x: FloatArray, periods: int) -> FloatArray:
        own = self.repetition
        return np.asarray(own.sign**periods * x - periods * own.turn, dtype=np.float64)

    def _check(self, run: Run) -> None:
        if run.outcome is not SimulationOutcome.COMPLETE:
            raise FitError(f"at {self.rate:.6g} steps/s: {run.outcome.value}")


def _times(apart: FloatArray, shift: FloatArray) -> int:
    """Return how many times a shift is nearest to what two states are apart by, told by the state it moves most."""
    at = int(np.argmax(np.abs(shift)))
    return round(float(apart[at] / shift[at]))
