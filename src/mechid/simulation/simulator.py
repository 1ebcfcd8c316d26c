"""Simulation of a compiled kernel over a record's time base, block by block."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import ModuleType

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.command import Command, Excitation, Timing
from mechid.kernel.compiled import CHATTER, DIVERGED, Buffers, Kernel, allocate, kernel_for, lane_places
from mechid.kernel.equilibrium import find_equilibrium
from mechid.plant.plant import Plant
from mechid.signal.series import Series
from mechid.simulation.block import Block, State
from mechid.simulation.instants import instants
from mechid.simulation.interruption import check_interruption
from mechid.simulation.rest import resting_outputs
from mechid.simulation.start import AT_REST, Start, begin_from_start
from mechid.simulation.switch_log import NO_JUMPS, Jumps, logged_switches, take_logged_jumps
from mechid.simulation.time_scale import time_scale
from mechid.simulation.trajectory import SimulationOutcome, Switching, Trajectory
from mechid.simulation.work import count_run

BLOCK, PLAIN_BLOCK = 1024, 16384
"""Samples per block, with sensitivities (the Jacobian stays in the cache) and without; blocks end at its multiples."""
JUMPS_EVERY = 4
"""Samples per jump for which a block has room; mechanisms reach about one jump in twenty samples."""
CLOSE_STEPS = 4
"""Substeps per step during the hundred samples after the start and after each break-away."""
ON_TIME = Timing()
_OUTCOMES = {DIVERGED: SimulationOutcome.DIVERGED, CHATTER: SimulationOutcome.CHATTER}


def outcome_of(status: int) -> SimulationOutcome:
    """Return the outcome of a run from a kernel's status."""
    return _OUTCOMES.get(status, SimulationOutcome.COMPLETE)


@dataclass(frozen=True)
class TimeBase:
    """Uniform sample instants in record time: start_s + k / sample_rate_hz, k < samples."""

    sample_rate_hz: float
    samples: int
    start_s: float = 0.0

    @property
    def interval_s(self) -> float:
        """Sample interval in s."""
        return 1.0 / self.sample_rate_hz

    @property
    def duration_s(self) -> float:
        """Time from the first sample to the last in s."""
        return (self.samples - 1) / self.sample_rate_hz

    @property
    def times(self) -> FloatArray:
        """All sample instants, (n,) s."""
        return self.start_s + np.arange(self.samples) / self.sample_rate_hz

    def truncate(self, samples: int) -> TimeBase:
        """Return the time base of the first samples."""
        return TimeBase(self.sample_rate_hz, min(samples, self.samples), self.start_s)


@dataclass(frozen=True, eq=False)
class Simulator:
    """One plant under one command on one time base; each run supplies the parameter values.

    Parameters
    ----------
    plant : Plant
    command : Command
    base : TimeBase
    sensitive : sequence of tuple of int
        Indices of the kernel's parameters whose sensitivities are computed; parameters of one tuple move together.
    latest_s : float
        Largest |time offset| of any run, s.
    capacity : int
        Largest number of directions of any run, if it exceeds that of `sensitive`; all runs share one kernel.
    known_edges : Excitation or None
        Result of `excitation_over`, if it has been computed already.
    start : Start
        Initial state, if other than at rest where the command begins.
    """

    plant: Plant
    command: Command
    base: TimeBase
    sensitive: Sequence[tuple[int, ...]] = ()
    latest_s: float = 0.0
    capacity: int = 0
    known_edges: Excitation | None = None
    start: Start = AT_REST

    @cached_property
    def kernel(self) -> Kernel:
        """The compiled kernel, with lanes if there are sensitivities."""
        return kernel_for(self.plant, max(self.capacity, len(self.sensitive)))

    @cached_property
    def excitation(self) -> Excitation:
        """All step edges that any run of this simulator can reach."""
        return self.known_edges or excitation_over(self.command, self.base, self.latest_s)

    @cached_property
    def _edge_values(self) -> FloatArray:
        return np.ascontiguousarray(self.excitation.values).ravel()

    @cached_property
    def directions(self) -> FloatArray:
        """Direction of each sensitivity in the space of the parameters, (n_p, m); grouped parameters move as one."""
        out = np.zeros((len(self.plant.parameters), len(self.sensitive)))
        for lane, together in enumerate(self.sensitive):
            out[list(together), lane] = 1.0
        return out

    def run(
        self,
        p: FloatArray,
        *,
        timing: Timing = ON_TIME,
        substeps: int = 1,
        block: int | None = None,
        events: int | None = 0,
        directions: FloatArray | None = None,
        samples: int | None = None,
    ) -> Run:
        """Begin a run at the kernel parameters `p`, (n_p,); iterate its `blocks`.

        `events` switches are logged; None logs output jumps block by block instead. `timing` converts record time to
        command time and says in which of the two the mechanism moves. `directions`, (n_p, m), replaces `sensitive` by m
        combinations of the parameters; `samples` limits the run to the first ones; `block` is the samples per block.
        """
        wanted = self.directions if directions is None else directions
        block = block or (BLOCK if wanted.shape[1] else PLAIN_BLOCK)
        base = self.base if samples is None else self.base.truncate(samples)
        run = Run(self, base, np.ascontiguousarray(p, dtype=np.float64), timing, substeps, block, events, wanted)
        start = run.scale.start(self.start) if run.scale else self.start
        begin_from_start(self.kernel, run.buffers, run.p, self.excitation.initial, self.command, start)
        return run


class Run:
    """One run in progress; `outcome` and `switching` are known once its blocks are consumed."""

    def __init__(
        self,
        simulator: Simulator,
        base: TimeBase,
        p: FloatArray,
        timing: Timing,
        substeps: int,
        block: int,
        events: int | None,
        directions: FloatArray,
    ) -> None:
        self.scale = time_scale(simulator.plant, timing)
        if self.scale:
            p, directions = p * self.scale.parameters, directions * self.scale.parameters[:, None]
        self.simulator, self.base, self.p = simulator, base, p
        self.block, self.substeps = min(block, max(base.samples, 1)), substeps
        kernel = simulator.kernel
        self.moved, self.runs_counted_as_one = directions.shape[1], 1
        self.interval_s = base.interval_s * timing.scale
        self.start_s = base.start_s * timing.scale - simulator.command.origin_s - timing.offset_s
        self.grid = self._grid(kernel.module, self.interval_s / substeps)
        self.jumping = () if events is not None else simulator.plant.jump_switches
        most = events or (max(self.block // JUMPS_EVERY, 1) if self.jumping else 0)
        self.buffers: Buffers = allocate(
            simulator.plant, kernel.module, samples=self.block, events=most, sensitive=directions.shape[1] > 0
        )
        self.buffers.directions.reshape(len(p), -1)[:, : directions.shape[1]] = directions
        self.outcome = SimulationOutcome.COMPLETE
        self._begin(*self._start())

    def _grid(self, module: ModuleType, step_s: float) -> FloatArray:
        """Return the grid of the kernel's `run`: instants and steps in command time, s."""
        grid = np.empty(4)
        grid[[module.GRID_START, module.GRID_INTERVAL]] = self.start_s, self.interval_s
        grid[[module.GRID_STEP, module.GRID_CLOSE]] = step_s, step_s / CLOSE_STEPS
        return grid

    def restart(self, state: State) -> None:
        """Begin at another state than the command's start, before any block is consumed."""
        self._begin(state.x, np.zeros(state.x.size * self.p.size))
        self.buffers.w[self._lane_rows[:, : state.lanes.shape[1]]] = state.lanes

    def _begin(self, x: FloatArray, x_p: FloatArray) -> None:
        simulator, b = self.simulator, self.buffers
        simulator.kernel.begin(
            self.p,
            b.directions,
            simulator.excitation.initial,
            simulator.command.start_angle_rad,
            x,
            x_p,
            b.discrete,
            b.w,
        )

    def _start(self) -> tuple[FloatArray, FloatArray]:
        """Return a start other than the commanded one with its derivatives; empty for that one and on failure."""
        simulator, command = self.simulator, self.simulator.command
        if command.start != "equilibrium":
            return np.zeros(0), np.zeros(0)
        at = find_equilibrium(simulator.plant, self.p, simulator.excitation.initial, command.start_angle_rad)
        self.outcome = self.outcome if at else SimulationOutcome.NO_EQUILIBRIUM
        return (at[0], np.ascontiguousarray(at[1]).ravel()) if at else (np.zeros(0), np.zeros(0))

    def blocks(self, stop: int | None = None) -> Iterator[Block]:
        """Yield the record, or its samples before `stop`, block by block; after a failure the samples are NaN.

        Blocks end at the multiples of their size, wherever the motion begins, so that runs of one size can be compared
        block by block. The interruption check is called before each block.
        """
        done, total, resting = 0, self.base.samples if stop is None else stop, self.resting
        self.buffers.discrete[int(self.simulator.kernel.module.NEXT_SAMPLE)] = resting
        while done < total:
            check_interruption()
            count = min(self.block - done % self.block, total - done)
            count_run(count * self.substeps // self.runs_counted_as_one, len(self.p), self.moved)
            still = min(max(resting - done, 0), count)
            if still:
                self._rest(still)
            if still < count:
                self._advance(still, count)
            yield self._block(done, count)
            done += count

    @property
    def resting(self) -> int:
        """Samples before command time 0, where the mechanism rests."""
        if self.start_s >= 0.0 or self.outcome is SimulationOutcome.NO_EQUILIBRIUM:
            return 0
        # A sample at command time 0, up to rounding, already moves.
        return min(int(np.ceil(-self.start_s / self.interval_s - 1e-9)), self.base.samples)

    def _rest(self, count: int) -> None:
        """Write the first rows of a block at rest; angles, positions and currents of the start may be nonzero."""
        simulator, b = self.simulator, self.buffers
        directions = b.directions.reshape(len(self.p), b.lanes)
        module, inputs = simulator.kernel.module, simulator.excitation.initial
        y, J = resting_outputs(simulator.plant, module, self.p, inputs, directions, b.w)
        b.y.reshape(-1, b.outputs)[:count] = y
        if b.sensitive:
            b.y_dot.reshape(-1, b.outputs)[:count] = 0.0
            b.J.reshape(-1, b.outputs, b.lanes)[:count] = J

    def prepare(self) -> None:
        """Initialise the run before its first sample, for callers that do not consume its blocks one by one."""
        self._advance(0, 0)

    def _advance(self, first: int, stop: int) -> None:
        """Simulate the rows of a block from `first` to `stop`."""
        buffers, simulator = self.buffers, self.simulator
        if self.outcome is not SimulationOutcome.COMPLETE:
            buffers.y[:] = np.nan
            return
        status = simulator.kernel.run(
            self.p,
            buffers.directions,
            int(buffers.sensitive),
            self.grid,
            simulator.excitation.times,
            simulator._edge_values,
            *buffers.run_arguments(first, stop),
        )
        self.outcome = outcome_of(int(status))

    def _block(self, start: int, count: int) -> Block:
        b, rows = self.buffers, count if self.buffers.sensitive else 0
        block = Block(
            start,
            start + count,
            b.y[: count * b.outputs].reshape(count, b.outputs),
            b.y_dot[: rows * b.outputs].reshape(rows, b.outputs),
            b.J[: rows * b.outputs * b.lanes].reshape(rows, b.outputs, b.lanes),
            self.take_jumps(b.events, b.discrete, start, count),
        )
        return self.scale.block(block) if self.scale else block

    def take_jumps(self, events: FloatArray, discrete: IntArray, first: int, count: int) -> Jumps:
        """Return and clear the output jumps of a block of samples from `first` on that has just been simulated."""
        module, begins_s = self.simulator.kernel.module, self.start_s + first * self.interval_s
        own = (begins_s, self.interval_s, count)
        found = take_logged_jumps(module, events, discrete, self.jumping, *own) if self.jumping else NO_JUMPS
        return self.scale.jumps(found) if self.scale else found

    @property
    def state(self) -> State:
        """State of the run at its last sample, before an edge at that instant."""
        w, first = self.buffers.w, int(self.simulator.kernel.module.AT_X)
        n = len(self.simulator.plant.states)
        return State(w[first : first + n].copy(), w[self._lane_rows[:, : self.moved]])

    @cached_property
    def _lane_rows(self) -> IntArray:
        """Positions of the lanes of each state in the workspace, (n_x, lanes)."""
        module, n = self.simulator.kernel.module, len(self.simulator.plant.states)
        return np.array([lane_places(module, int(module.ROW_S) + i, self.buffers.lanes) for i in range(n)])

    @property
    def switching(self) -> Switching:
        """Switches logged so far."""
        return logged_switches(self.simulator.kernel.module, self.buffers.events, self.buffers.discrete, self.moved)


def excitation_over(command: Command, base: TimeBase, latest_s: float = 0.0) -> Excitation:
    """Return all step edges of a record that may be up to `latest_s` early or late."""
    end = base.start_s - command.origin_s + base.samples * base.interval_s
    return command.excitation(max(end + latest_s, 0.0))


def simulate_run(run: Run) -> Trajectory:
    """Consume a run and return its trajectory."""
    simulator = run.simulator
    n, m, quantities = run.base.samples, len(simulator.sensitive), tuple(simulator.plant.outputs)
    y = np.empty((len(quantities), n))
    rate, J = np.empty((n if m else 0, len(quantities))), np.empty((n if m else 0, len(quantities), m))
    for block in run.blocks():
        rows = slice(block.start, block.stop)
        y[:, rows] = block.y.T
        if m:
            rate[rows], J[rows] = block.rate, block.jacobian[:, :, :m]
    return replace(
        trajectory_of(run, list(y)).in_memory,
        jacobian={q: J[:, j] for j, q in enumerate(quantities)} if m else {},
        rate={q: rate[:, j] for j, q in enumerate(quantities)} if m else {},
        parameters=tuple(str(simulator.plant.parameters[i[0]]) for i in simulator.sensitive),
    )


def trajectory_of(run: Run, y: Sequence[Series]) -> Trajectory:
    """Return the trajectory of a consumed run without sensitivities; `y` are its outputs."""
    return Trajectory(
        time=instants(run.base.start_s, run.base.sample_rate_hz, run.base.samples),
        values=dict(zip(run.simulator.plant.outputs, y, strict=True)),
        jacobian={},
        rate={},
        parameters=(),
        switching=run.switching,
        outcome=run.outcome,
        substeps=run.substeps,
    )
