"""Map of the state over one period of the steps, with exact derivatives across switches.

After n full steps, n/r s at r full steps/s, the mechanism is the same except for a sign and a turn of its states, which
`simulation.repetition` finds. In the paper's mechanism this is after two steps: the currents change sign, the rotor is
3.6 deg and the load 3.6 deg/G further, and the rotor may stand any multiple of 7.2 deg (the load of 7.2 deg/G)
elsewhere. States are taken modulo these shifts, so that a repeating motion is a fixed point.
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
from mechid.command import Command, RateProfile
from mechid.errors import FitError
from mechid.plant.block import PolarPair
from mechid.plant.mechanism import Mechanism
from mechid.simulation.block import State
from mechid.simulation.repetition import Repetition, repetition
from mechid.simulation.simulator import Run, Simulator, TimeBase
from mechid.simulation.trajectory import SimulationOutcome


@dataclass(frozen=True, eq=False)
class Image:
    """Image of a state after some periods.

    Attributes
    ----------
    x : (n,)
        Final state.
    by_state : (n, n)
        Its derivative with respect to the initial state.
    by_parameter : (n, p)
        Its derivative with respect to the parameters, for a fixed start or including the start's own derivatives.
    size : (n,)
        Range of each state on the way.
    """

    x: FloatArray
    by_state: FloatArray
    by_parameter: FloatArray
    size: FloatArray


@dataclass(frozen=True, eq=False)
class Stretch:
    """Torque over some periods.

    Attributes
    ----------
    torque : (N,)
        N m; the last sample is before the end of the last period.
    below : (N, 1 + p)
        Low-pass filtered torque, followed by its derivatives with respect to the parameters.
    """

    torque: FloatArray
    below: FloatArray


def directions(mechanism: Mechanism, names: Sequence[str]) -> FloatArray:
    """Return the derivative of the kernel's parameters with respect to each named parameter, (n_p, p)."""
    slopes, count = mechanism.kernel_jacobian(), mechanism.kernel_values().size
    return np.column_stack([np.zeros((count, 0)), *(slopes[name] for name in names)])


@dataclass(frozen=True, eq=False)
class PeriodMap:
    """Mechanism stepped at one rate.

    Parameters
    ----------
    mechanism : Mechanism
        In flight; `plant.flight.with_line_filter` adds the torque below a cut-off to its outputs.
    mode : OperatingMode
    rate : float
        Full steps/s.
    names : tuple of str, (p,)
        Parameters whose derivatives are needed.
    substeps : int
        Integration steps per sample.
    whole : Mechanism or None
        Mechanism with the harmonics that `mechanism` leaves out since they keep it from repeating; None if it is all.
    apart : tuple of PolarPair
        These harmonics, whose amplitudes are 0 in `mechanism` and change nothing that repeats.
    """

    mechanism: Mechanism
    mode: OperatingMode
    rate: float
    names: tuple[str, ...]
    substeps: int
    whole: Mechanism | None = None
    apart: tuple[PolarPair, ...] = ()

    @cached_property
    def repetition(self) -> Repetition:
        """Symmetry after which the motion may repeat within `MOTION.longest_s`."""
        return repetition(self.mechanism, MOTION.longest_s * self.rate, self.mode.command.mirrored_steps)

    @property
    def repeats(self) -> bool:
        """Whether the motion may repeat; it cannot on a step clock with a tick."""
        return bool(self.repetition.steps) and not self.mode.command.clock_tick_s

    @property
    def steps(self) -> int:
        """Full steps in a period; for a motion that cannot repeat, the period of the voltages."""
        return self.repetition.steps or self.mode.command.mirrored_steps

    @property
    def duration_s(self) -> float:
        """Duration of a period."""
        return self.steps / self.rate

    @property
    def samples(self) -> int:
        """Samples in a period, a whole number per step, so that lines are bins and step edges fall on samples."""
        each = self.steps * self.mode.command.steps_per_full_step
        wanted = max(MOTION.sample_rate_hz, MOTION.above_cut_off * self.mode.highest_hz) * self.duration_s
        return each * math.ceil(wanted / each)

    @property
    def sample_rate_hz(self) -> float:
        """Sample rate."""
        return self.samples / self.duration_s

    @property
    def of_whole(self) -> PeriodMap:
        """The map with all harmonics."""
        return self if self.whole is None else replace(self, mechanism=self.whole, whole=None, apart=())

    @cached_property
    def command(self) -> Command:
        """Command of the mode at this rate."""
        return replace(self.mode.command, rate=RateProfile.constant(self.rate))

    @cached_property
    def _simulators(self) -> dict[tuple[int, int, int], Simulator]:
        """Simulators by samples, lanes and finer: each holds its step edges, which take longer than a period's run."""
        return {}

    @cached_property
    def _may_stick(self) -> BoolArray:
        """Whether friction may hold a state at zero, (n,)."""
        switches = self.mechanism.plant.switches
        at_rest = {s for switch in switches for guards in switch.guards.values() for g in guards for s in g.resets}
        return np.array([s in at_rest for s in self.mechanism.plant.states])

    def state_after(self, x: FloatArray | None, periods: int) -> FloatArray:
        """Return the state some periods after a given state, or after rest.

        Raises
        ------
        FitError
            The mechanism diverged.
        """
        run = self._run(periods, State(x, np.zeros((x.size, 0))) if x is not None else None, self._directions[:, :0], 0)
        for _ in run.blocks():
            pass
        self._check(run)
        return self._to_start_frame(run.state.x, periods)

    def __call__(
        self, x: FloatArray, periods: int = 1, by_parameter: FloatArray | None = None, own: FloatArray | None = None
    ) -> Image:
        """Return the image of a state after some periods.

        Parameters
        ----------
        x : (n,)
        periods : int
        by_parameter : (n, p) or None
            Derivatives of `x` to the parameters; None: 0.
        own : (n_p, p) or None
            Directions of the kernel's parameters for the derivatives; None: those of `names`.

        Raises
        ------
        FitError
            The mechanism diverged.
        """
        own = self._directions if own is None else own
        n, p = x.size, own.shape[1]
        seen = [x]
        # A held state does not move with its own deviation: its column of the derivative is zero.
        lanes = np.hstack(
            [np.zeros((n, p)) if by_parameter is None else by_parameter, np.diag(1.0 - self.pinned_states(x))]
        )
        run = self._run(periods, State(x, lanes), own, n)
        for _ in run.blocks():
            seen.append(run.state.x)
        self._check(run)
        # The sign brings the derivatives to the frame of the start, as `_to_start_frame` does with the state.
        lanes = self.repetition.sign[:, None] ** periods * run.state.lanes
        size = np.ptp(np.array(seen), axis=0)
        return Image(
            x=self._to_start_frame(run.state.x, periods),
            by_state=lanes[:, p:],
            by_parameter=lanes[:, :p],
            # A state that does not move has no scale of its own; 1 avoids division by zero.
            size=np.where(size > 0.0, size, 1.0),
        )

    def stretch(
        self,
        start: State | None,
        skipped: int,
        periods: int,
        *,
        slopes: bool = True,
        finer: int = 1,
        own: FloatArray | None = None,
        values: FloatArray | None = None,
    ) -> Stretch:
        """Return the torque over some periods after a number of skipped ones, from a state or from rest.

        Parameters
        ----------
        start : State or None
            Its lanes are derivatives with respect to the parameters; none without slopes.
        skipped, periods : int
        slopes : bool
            Whether derivatives with respect to the parameters are needed.
        finer : int
            Factor on the number of samples and of steps per period.
        own : (n_p, p) or None
            Directions of the kernel's parameters for the derivatives; None: those of `names`.
        values : (n_p,) or None
            Kernel's parameters; None: those of `mechanism`.

        Raises
        ------
        FitError
            The mechanism diverged.
        """
        n = finer * self.samples
        simulator = self.simulator((skipped + periods) * n + 1, self.lanes, finer)
        own = (self._directions if slopes else self._directions[:, :0]) if own is None else own
        p = self.mechanism.kernel_values() if values is None else values
        run = simulator.run(p, substeps=self.substeps, directions=own)
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

    def pinned_states(self, x: FloatArray) -> FloatArray:
        """Return 1 for each state that friction holds, (n,), 0 for the others."""
        return np.asarray(self._may_stick & (x == 0.0), dtype=np.float64)

    def turns_off(self, apart: FloatArray) -> int:
        """Return the distance of two states in electrical periods of the rotor, as a whole number."""
        return _whole_shifts(apart, self.repetition.electrical)

    def modulo(self, apart: FloatArray) -> FloatArray:
        """Return the difference of two states, (n,), modulo the shifts that change nothing."""
        return np.asarray(apart - _whole_shifts(apart, self.repetition.whole) * self.repetition.whole, dtype=np.float64)

    def simulator(self, samples: int, lanes: int, finer: int = 1) -> Simulator:
        """Return the simulator of the steps at this rate, with a factor on the sample rate."""
        key = samples, lanes, finer
        if key not in self._simulators:
            base = TimeBase(finer * self.sample_rate_hz, samples)
            self._simulators[key] = Simulator(self.mechanism.plant, self.command, base, capacity=lanes)
        return self._simulators[key]

    @property
    def lanes(self) -> int:
        """Largest number of derivatives that are integrated."""
        return max(len(self.names), 2 * len(self.apart)) + len(self.mechanism.plant.states)

    @cached_property
    def _directions(self) -> FloatArray:
        """Derivative of the kernel's parameters to each named parameter, (n_p, p), 0 for harmonics left out."""
        own, apart = directions(self.mechanism, self.names), {pair.amplitude for pair in self.apart}
        own[:, [name in apart for name in self.names]] = 0.0
        return own

    def _run(self, periods: int, start: State | None, own: FloatArray, state_lanes: int) -> Run:
        simulator = self.simulator(periods * self.samples + 1, self.lanes)
        lanes = np.hstack([own, np.zeros((len(own), state_lanes))])
        # The range of each state is taken over the ends of the blocks.
        block = math.ceil(self.samples / MOTION.looks) if state_lanes else None
        run = simulator.run(self.mechanism.kernel_values(), substeps=self.substeps, directions=lanes, block=block)
        if start is not None:
            run.restart(start)
        return run

    def _to_start_frame(self, x: FloatArray, periods: int) -> FloatArray:
        own = self.repetition
        return np.asarray(own.sign**periods * x - periods * own.turn, dtype=np.float64)

    def _check(self, run: Run) -> None:
        if run.outcome is not SimulationOutcome.COMPLETE:
            raise FitError(f"at {self.rate:.6g} steps/s: {run.outcome.value}")


def _whole_shifts(apart: FloatArray, shift: FloatArray) -> int:
    """Return the multiple of a shift nearest to a difference of states, by the state that the shift moves most."""
    at = int(np.argmax(np.abs(shift)))
    return round(float(apart[at] / shift[at]))
