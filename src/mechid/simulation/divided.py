"""A run whose derivatives are shared among threads: each carries the motion and some of the directions.

A lane's arithmetic does not depend on the other groups of lanes, so the values are those of one thread to the last bit.
Each thread repeats the motion itself, a fourth to a seventh of a run with fifteen derivatives.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.kernel.tangents import WIDTH
from mechid.simulation.block import Block
from mechid.simulation.interruption import check_interruption
from mechid.simulation.simulator import Run, Simulator
from mechid.simulation.trajectory import SimulationOutcome
from mechid.simulation.work import count_run

AHEAD = 4
"""Blocks that a thread may be ahead of the consumer: enough that it seldom waits, and a few hundred kilobytes."""


class DividedRun:
    """A run with derivatives on several threads; it is consumed once, as `Run` is.

    Parameters
    ----------
    simulator : Simulator
    p : (n_p,)
        Parameters of the kernel.
    directions : (n_p, m)
        Directions of the derivatives.
    threads : int
        Threads, at most one a group of lanes.
    options
        Those of `Simulator.run`.
    """

    def __init__(
        self, simulator: Simulator, p: FloatArray, directions: FloatArray, threads: int, **options: Any
    ) -> None:
        self.moved = directions.shape[1]
        self._lanes = divide_lanes(self.moved, threads)
        self._runs = [_part(simulator, p, directions, lanes, options) for lanes in self._lanes]
        self.block = self._runs[0].block

    @property
    def outcome(self) -> SimulationOutcome:
        """Outcome so far."""
        return self._runs[0].outcome

    def blocks(self) -> Iterator[Block]:
        """Yield the record block by block; the interruption check is called, and the work counted, in this thread."""
        first = self._runs[0]
        sizes = [min(self.block, first.base.samples - done) for done in range(0, first.base.samples, self.block)]
        # One array for all blocks: a new one of this size for each would be new pages of memory each time.
        jacobian = np.zeros((self.block, first.buffers.outputs, first.buffers.lanes))
        with ExitStack() as stack:
            # A thread for each part, so that its blocks follow one another without a lock.
            pools = [stack.enter_context(ThreadPoolExecutor(1)) for _ in self._runs]
            parts = [run.blocks() for run in self._runs]
            waiting: deque[list[Future[Block]]] = deque()
            stack.callback(_cancel, waiting)
            for number, size in enumerate(sizes):
                while len(waiting) < min(AHEAD, len(sizes) - number):
                    submitted = zip(pools, parts, self._lanes, strict=True)
                    waiting.append([pool.submit(_copy_next, part, lanes) for pool, part, lanes in submitted])
                check_interruption()
                count_run(size * first.substeps, len(first.p), self.moved)
                yield self._join([future.result() for future in waiting.popleft()], jacobian)

    def _join(self, blocks: Sequence[Block], jacobian: FloatArray) -> Block:
        """Return a block with the derivatives of all parts, written to `jacobian`, (block, n_y, lanes)."""
        rows = jacobian[: len(blocks[0].jacobian)]
        for block, lanes in zip(blocks, self._lanes, strict=True):
            rows[:, :, lanes] = block.jacobian
        return replace(blocks[0], jacobian=rows)


def divide_lanes(directions: int, threads: int) -> list[slice]:
    """Return the lanes of each thread: whole groups, as equal in number as can be.

    Examples
    --------
    >>> divide_lanes(18, 2)
    [slice(0, 12, None), slice(12, 18, None)]
    """
    groups = -(-directions // WIDTH)
    count = max(min(threads, groups), 1)
    # The first ones have one group more where they do not divide.
    ends = [-(-groups * k // count) * WIDTH for k in range(count)] + [directions]
    return [slice(one, other) for one, other in pairwise(ends)]


def _part(simulator: Simulator, p: FloatArray, directions: FloatArray, lanes: slice, options: dict[str, Any]) -> Run:
    """Begin the run of some of the directions, in the lanes in which the whole run has them."""
    own = np.zeros_like(directions)
    own[:, lanes] = directions[:, lanes]
    carried = {n: slopes for n, slopes in simulator.start.lanes.items() if lanes.start <= n < lanes.stop}
    return replace(simulator, start=replace(simulator.start, lanes=carried)).run(p, directions=own, **options)


def _copy_next(blocks: Iterator[Block], lanes: slice) -> Block:
    """Return the next block, which nothing overwrites, with the derivatives of some lanes."""
    block = next(blocks)
    return replace(block, y=block.y.copy(), rate=block.rate.copy(), jacobian=block.jacobian[:, :, lanes].copy())


def _cancel(waiting: Sequence[Sequence[Future[Block]]]) -> None:
    for futures in waiting:
        for future in futures:
            future.cancel()
