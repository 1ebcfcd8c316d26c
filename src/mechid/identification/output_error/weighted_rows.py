"""The columns of a target's least-squares problem, block by block, weighted as they count."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from mechid.identification.output_error.target import Target, TargetChannel
from mechid.kernel.compiled import aligned
from mechid.simulation.simulator import Block
from mechid.simulation.trajectory import SimulationOutcome

if TYPE_CHECKING:
    from mechid.identification.output_error.problem import Problem

FloatArray = NDArray[np.float64]
BETWEEN = 40
"""Unused numbers behind each row, whole cache lines: of rows that are pages apart the processor confuses the places."""


class WeightedRows:
    """Blocks of the columns of [Phi r J] of a target's channels as rows, prefiltered, without what does not count.

    Iteration gives (k, rows, n): n samples of channel k in rows[:, :n], which the next block overwrites. Offset and
    drift are filtered too. The first samples of a window, as many as the prefilter remembers, rejected ones and as
    many that follow these are zero: behind each gap the whitening starts anew. Nothing is divided by sigma.
    """

    def __init__(
        self, problem: Problem, target: Target, q: FloatArray, window: tuple[int, int], *, jacobian: bool
    ) -> None:
        self.problem, self.target, self.window, self.jacobian = problem, target, window, jacobian
        self.widths = [c.linear + 1 + (problem.size if jacobian else 0) for c in target.channels]
        self.run = problem.run(target, q, window[1], jacobian=jacobian)

    @property
    def succeeded(self) -> bool:
        """Whether the simulation came to the window's end; known after the iteration."""
        return self.run.outcome is SimulationOutcome.COMPLETE

    def __iter__(self) -> Iterator[tuple[int, FloatArray, int]]:
        channels = self.target.channels
        memories = [np.zeros((width, c.order)) for width, c in zip(self.widths, channels, strict=True)]
        apart = self.run.block + BETWEEN
        buffers = [aligned(width * apart).reshape(width, apart) for width in self.widths]
        for block in self.run.blocks():
            first = max(block.start, self.window[0])
            if first >= block.stop:
                continue
            n = block.stop - first
            for k, (channel, rows) in enumerate(zip(channels, buffers, strict=True)):
                self._write(rows, channel, block, first, n)
                if channel.prefilter is not None:
                    taps = channel.prefilter.coefficients
                    rows[:, :n], memories[k] = lfilter(taps, [1.0], rows[:, :n], axis=1, zi=memories[k])
                self._drop(rows, channel, first, n)
                yield k, rows, n

    def _write(self, rows: FloatArray, channel: TargetChannel, block: Block, first: int, n: int) -> None:
        """Write the last n samples of a block as rows."""
        problem, linear = self.problem, channel.linear
        problem.linear_rows(rows, linear, self.window, first, n)
        y = block.y[-n:, problem.output(channel.quantity)]
        rows[linear, :n] = y - channel.measured[first : block.stop]
        if self.jacobian:
            problem.write_jacobian(rows[linear + 1 :], self.target, channel, block, n)

    def _drop(self, rows: FloatArray, channel: TargetChannel, first: int, n: int) -> None:
        """Set to zero what does not count of the samples from `first` on."""
        order = channel.order
        rows[:, : min(max(self.window[0] + order - first, 0), n)] = 0.0
        if channel.rejected.size:
            near = channel.rejected_within((first - order, first + n)) - order
            spoilt = (near[:, np.newaxis] + np.arange(order + 1)).ravel()
            rows[:, spoilt[(spoilt >= 0) & (spoilt < n)]] = 0.0
