"""Latest runs without sensitivities, whose samples are kept for the next that asks for the same simulation.

The end of a fit asks for the same one up to eight times: for score, covariance, horizon, fit of the record, hum and
prediction. A kept run yields the samples, and counts the work, of the run itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from threading import Lock
from typing import Protocol

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import Excitation, Timing
from mechid.simulation.block import Block
from mechid.simulation.interruption import check_interruption
from mechid.simulation.simulator import ON_TIME, PLAIN_BLOCK, Run, Simulator
from mechid.simulation.switch_log import NO_JUMPS, Jumps
from mechid.simulation.trajectory import SimulationOutcome
from mechid.simulation.work import count_run

MOST_NUMBERS = 2**22
"""Most output values that are kept of all runs together, 32 MiB: three records of a minute with a few outputs."""


class Blocks(Protocol):
    """A run whose blocks are consumed in order; its outcome is known afterwards."""

    @property
    def block(self) -> int:
        """Largest number of samples in a block."""

    @property
    def outcome(self) -> SimulationOutcome:
        """Outcome so far."""

    def blocks(self) -> Iterator[Block]:
        """Yield the record block by block."""


@dataclass(frozen=True, eq=False)
class _Kept:
    """Outputs of a run, (n, n_y), with the jumps and the outcome of each of its blocks."""

    run: Run
    y: FloatArray
    jumps: tuple[Jumps, ...]
    outcomes: tuple[SimulationOutcome, ...]

    def is_same(self, run: Run) -> bool:
        """Tell whether another run that has not begun is the same simulation."""
        mine, other = self.run.simulator, run.simulator
        return (
            mine.kernel.module is other.kernel.module
            and np.array_equal(self.run.p, run.p)
            and _times(self.run) == _times(run)
            and mine.start.values == other.start.values
            and _is_same_excitation(mine.excitation, other.excitation)
        )

    def fits(self, block: int) -> bool:
        """Tell whether the run can be repeated in blocks of another size, which moves the jumps of a block."""
        return block == self.run.block or all(jumps is NO_JUMPS for jumps in self.jumps)


class KeptRun:
    """A kept run that is consumed once more, in blocks of any size."""

    def __init__(self, kept: _Kept, block: int) -> None:
        self._kept, self.block = kept, block
        self.outcome = SimulationOutcome.COMPLETE

    def blocks(self) -> Iterator[Block]:
        """Yield the record block by block; the samples must not be written to."""
        kept, run = self._kept, self._kept.run
        none = np.empty((0, kept.y.shape[1]))
        for start in range(0, len(kept.y), self.block):
            check_interruption()
            stop = min(start + self.block, len(kept.y))
            count_run((stop - start) * run.substeps, len(run.p), 0)
            whole = start // run.block
            self.outcome = kept.outcomes[whole]
            jumps = kept.jumps[whole] if self.block == run.block else NO_JUMPS
            yield Block(start, stop, kept.y[start:stop], none, np.empty((*none.shape, 0)), jumps)


class _KeepingRun:
    """A run whose samples are kept as they are consumed."""

    def __init__(self, run: Run, keep: SharedRuns) -> None:
        self._run, self._keep, self.block = run, keep, run.block

    @property
    def outcome(self) -> SimulationOutcome:
        """Outcome so far."""
        return self._run.outcome

    def blocks(self) -> Iterator[Block]:
        """Yield the record block by block."""
        y = np.empty((self._run.base.samples, len(self._run.simulator.plant.outputs)))
        jumps, outcomes = list[Jumps](), list[SimulationOutcome]()
        for block in self._run.blocks():
            y[block.start : block.stop] = block.y
            jumps.append(block.jumps if block.jumps.samples.size else NO_JUMPS)
            outcomes.append(self._run.outcome)
            yield block
        y.flags.writeable = False
        self._keep.add(_Kept(self._run, y, tuple(jumps), tuple(outcomes)))


class SharedRuns:
    """Runs kept for repetition, the latest last; the oldest go when there are more than `most` output values."""

    def __init__(self, most: int = MOST_NUMBERS) -> None:
        self._most, self._lock = most, Lock()
        self._kept: tuple[_Kept, ...] = ()

    def begin(
        self,
        simulator: Simulator,
        p: FloatArray,
        *,
        timing: Timing = ON_TIME,
        substeps: int = 1,
        block: int | None = None,
        samples: int | None = None,
    ) -> Blocks:
        """Begin a run without sensitivities that notes its jumps; the parameters are those of `Simulator.run`."""
        none = np.zeros((len(p), 0))
        run = simulator.run(
            p, timing=timing, substeps=substeps, block=block, events=None, directions=none, samples=samples
        )
        numbers = run.base.samples * len(simulator.plant.outputs)
        # A shorter run takes little more time than the search among the kept ones.
        if run.base.samples < PLAIN_BLOCK or numbers > self._most:
            return run
        same = next((one for one in self._kept if one.is_same(run)), None)
        if same is not None and same.fits(run.block):
            return KeptRun(same, run.block)
        return run if same is not None or block is not None else _KeepingRun(run, self)

    def add(self, kept: _Kept) -> None:
        """Keep a run, and let the oldest ones go."""
        with self._lock:
            held, left = [kept], self._most - kept.y.size
            for one in reversed(self._kept):
                left -= one.y.size
                if left < 0:
                    break
                held.append(one)
            self._kept = tuple(reversed(held))


SHARED_RUNS = SharedRuns()
"""The runs of this process."""


def _times(run: Run) -> tuple[object, ...]:
    """Return the instants and steps of a run, the units of its outputs, and all that it takes of its command."""
    command, scale = run.simulator.command, run.scale
    outputs = None if scale is None else tuple(scale.outputs.tolist())
    own = command.start, command.start_angle_rad
    return run.base, run.start_s, run.interval_s, run.substeps, outputs, *own


def _is_same_excitation(one: Excitation, other: Excitation) -> bool:
    return one is other or all(
        np.array_equal(a, b)
        for a, b in ((one.initial, other.initial), (one.times, other.times), (one.values, other.values))
    )
