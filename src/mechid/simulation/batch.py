"""Simultaneous runs of one simulator at several parameter points, in one vectorised kernel."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from mechid.arrays import FloatArray
from mechid.kernel.batch.compiled import BatchKernel, allocate_batch, batch_kernel_for
from mechid.kernel.batch.source import SETS
from mechid.kernel.compiled import DIVERGED, SUCCESS
from mechid.simulation.block import Block
from mechid.simulation.interruption import check_interruption
from mechid.simulation.simulator import Run, outcome_of
from mechid.simulation.switch_log import NO_JUMPS, Jumps, concatenate_jumps
from mechid.simulation.trajectory import SimulationOutcome
from mechid.simulation.work import count_batch

BLOCK = 4096
"""Samples per block of a batch, so that the outputs of a block stay in the processor's cache."""


class Batch:
    """Prepared runs that are simulated side by side.

    Parameters
    ----------
    runs : sequence of Run
        At most `SETS` fresh runs without directions, of one kernel, one command and one number of samples. They end in
        the same state as if each had been simulated alone.
    """

    def __init__(self, runs: Sequence[Run]) -> None:
        self.runs, self.base = runs, runs[0].base
        self.kernel: BatchKernel = batch_kernel_for(runs[0].simulator.kernel)
        self.block = min(BLOCK, max(self.base.samples, 1))
        self.buffers = allocate_batch(self.kernel, events=runs[0].buffers.events.size)
        self._at_first: list[Jumps] = []

    def each(self, begin: int = 0) -> list[BatchMember]:
        """Return the runs one by one. They must be consumed in step: one block of all of them before the next of any.

        Blocks that end at `begin` or before are simulated but not returned, since a reader that skips blocks would fall
        out of step.
        """
        shared = _Shared(self._blocks_behind(begin))
        return [BatchMember(self, k, shared) for k in range(len(self.runs))]

    def _blocks_behind(self, begin: int) -> Iterator[tuple[int, int, FloatArray]]:
        for start, stop, y in self.blocks():
            if stop > begin:
                yield start, stop, y
                continue
            for k in range(len(self.runs)):
                # The kernel's log of a block is cleared when it is read; the next block starts with an empty one.
                self.jumps_of(k, start, stop)  # those of the next block are noted anew

    def blocks(self) -> Iterator[tuple[int, int, FloatArray]]:
        """Yield first sample, last sample plus one, and outputs, (runs, n, n_y), which the next block overwrites.

        After a failure the samples of a run are NaN. The interruption check is called before each block.
        """
        n_y, excitation = self.runs[0].buffers.outputs, self.runs[0].simulator.excitation
        resting = max(run.resting for run in self.runs)
        if resting:
            yield 0, resting, self._at_rest(resting)
        self._at_first = []
        self._take()
        values, y = np.ascontiguousarray(excitation.values).ravel(), np.zeros(self.block * n_y * SETS)
        for done, stop in pairwise(self._ends(resting)):
            check_interruption()
            count = stop - done
            count_batch(len(self.runs) * count * self.runs[0].substeps, len(self.runs[0].p))
            part = y[: SETS * count * n_y]
            self.kernel.run(*self.buffers.arguments(excitation.times, values, part))
            outputs = part.reshape(SETS, count, n_y)[: len(self.runs)]
            for k, run in enumerate(self.runs):
                # The kernel works in the driver's time.
                if run.scale:
                    outputs[k] *= run.scale.outputs
            yield done, stop, outputs
        self._give()

    def _ends(self, first: int) -> list[int]:
        """Return the block boundaries from a sample on: the multiples of the block size, and the end."""
        inner = range((first // self.block + 1) * self.block, self.base.samples, self.block)
        return sorted({first, *inner, self.base.samples})

    def jumps_of(self, k: int, start: int, stop: int) -> Jumps:
        """Return and clear the output jumps of a run in the block yielded last."""
        if self._at_first:
            found, self._at_first[k] = self._at_first[k], NO_JUMPS
            return found
        return self.runs[k].take_jumps(self.buffers.events[k], self.buffers.owns[k], start, stop - start)

    def _at_rest(self, samples: int) -> FloatArray:
        """Return the outputs up to the last run's start of motion, (runs, n, n_y); other runs already move."""
        y = np.zeros((len(self.runs), samples, self.runs[0].buffers.outputs))
        for k, run in enumerate(self.runs):
            noted = []
            for block in run.blocks(samples):
                y[k, block.start : block.stop] = block.y
                noted.append(block.jumps.shift_by(block.start))
            self._at_first.append(concatenate_jumps(noted))
        return y

    def _take(self) -> None:
        """Load the states of the runs into the batch; unused sets repeat the last run."""
        b = self.buffers
        for run in self.runs:
            run.prepare()
        for k in range(SETS):
            # A copy takes no extra time in a vector register and cannot fail where the original does not.
            run = self.runs[min(k, len(self.runs) - 1)]
            b.p[k], b.grids[k], b.owns[k], b.ones[k] = run.p, run.grid, run.buffers.discrete, run.buffers.w
            b.events[k] = run.buffers.events
            b.statuses[k] = SUCCESS if run.outcome is SimulationOutcome.COMPLETE else DIVERGED
        b.copy_constants(self.kernel)

    def _give(self) -> None:
        """Store the states of the batch back into the runs."""
        b, states = self.buffers, self.kernel.states
        together = b.w.reshape(-1, SETS)
        for k, run in enumerate(self.runs):
            if together[int(self.kernel.module.GOING), k]:
                b.ones[k, states] = together[states, k]
            run.buffers.discrete[:], run.buffers.w[:], run.buffers.events[:] = b.owns[k], b.ones[k], b.events[k]
            if run.outcome is SimulationOutcome.COMPLETE:  # else it had failed while others still rested
                run.outcome = outcome_of(int(b.statuses[k]))


class _Shared:
    """Latest block of a batch, shared by its runs."""

    def __init__(self, source: Iterator[tuple[int, int, FloatArray]]) -> None:
        self.source, self.number = source, -1
        self.latest: tuple[int, int, FloatArray] | None = None

    def at(self, number: int) -> tuple[int, int, FloatArray] | None:
        """Return a block by number, the latest or the next; None after the last."""
        if number == self.number + 1:
            self.number, self.latest = number, next(self.source, None)
        assert number == self.number, "the runs of a batch are consumed in step"
        return self.latest


@dataclass(frozen=True, eq=False)
class BatchMember:
    """One run of a batch, with the interface of a run that is simulated alone."""

    batch: Batch
    k: int
    shared: _Shared

    @property
    def block(self) -> int:
        """Largest number of samples in a block."""
        return max(self.batch.block, *(run.resting for run in self.batch.runs), 1)

    @property
    def outcome(self) -> SimulationOutcome:
        """Outcome of the run, known once its blocks are consumed."""
        return self.batch.runs[self.k].outcome

    def blocks(self) -> Iterator[Block]:
        """Yield the record block by block; after a failure the samples are NaN."""
        number = 0
        while (found := self.shared.at(number)) is not None:
            start, stop, y = found
            n_y, jumps = y.shape[2], self.batch.jumps_of(self.k, start, stop)
            yield Block(start, stop, y[self.k], np.zeros((0, n_y)), np.zeros((0, n_y, 0)), jumps)
            number += 1
