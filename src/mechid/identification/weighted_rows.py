"""The columns of a target's least-squares problem, block by block, weighted as they count."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from mechid.simulation.trajectory import SimulationOutcome

if TYPE_CHECKING:
    from mechid.identification.problem import Problem, Target

FloatArray = NDArray[np.float64]


class WeightedRows:
    """Blocks of the columns of [Phi r J] of a target as rows, prefiltered, without what does not count.

    Iteration gives (rows, n): n samples in rows[:, :n], which the next block overwrites. Offset and drift are
    filtered too. The first samples of a window, as many as the prefilter remembers, and those that follow a
    rejected one are zero. Nothing is divided by sigma.
    """

    def __init__(
        self, problem: Problem, target: Target, q: FloatArray, window: tuple[int, int], *, jacobian: bool
    ) -> None:
        self.problem, self.target, self.window, self.jacobian = problem, target, window, jacobian
        self.width = target.linear + 1 + (problem.size if jacobian else 0)
        self.run = problem.run(target, q, window[1], jacobian=jacobian)

    @property
    def succeeded(self) -> bool:
        """Whether the simulation came to the window's end; known after the iteration."""
        return self.run.outcome is SimulationOutcome.COMPLETE

    def __iter__(self) -> Iterator[tuple[FloatArray, int]]:
        problem, target, linear = self.problem, self.target, self.target.linear
        memory = np.zeros((self.width, self._order))
        rows = np.zeros((self.width, self.run.block))
        for block in self.run.blocks():
            first = max(block.start, self.window[0])
            if first >= block.stop:
                continue
            n = block.stop - first
            problem.linear_rows(rows, target, self.window, first, n)
            rows[linear, :n] = block.y[-n:, 0] - target.measured[first : block.stop]
            if self.jacobian:
                problem.write_jacobian(rows[linear + 1 :], target, block, n)
            if target.prefilter is not None:
                rows[:, :n], memory = lfilter(target.prefilter.coefficients, [1.0], rows[:, :n], axis=1, zi=memory)
            self._drop(rows, first, n)
            yield rows, n

    @property
    def _order(self) -> int:
        return self.target.prefilter.order if self.target.prefilter else 0

    def _drop(self, rows: FloatArray, first: int, n: int) -> None:
        """Set to zero what does not count of the samples from `first` on."""
        rows[:, : min(max(self.window[0] + self._order - first, 0), n)] = 0.0
        rejected = self.target.rejected
        near = rejected[(rejected >= first - self._order) & (rejected < first + n)] if rejected.size else rejected
        for k in near.tolist():
            rows[:, max(k - first, 0) : min(k - first + self._order + 1, n)] = 0.0
