"""Compilation of batch modules, cached beside their kernels, and the buffers of a batch run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from mechid.arrays import FloatArray, IntArray
from mechid.kernel.batch.source import SETS, fingerprint, generate
from mechid.kernel.compiled import Kernel, aligned_zeros, compiled_module
from mechid.kernel.pointers import address_of


@dataclass(frozen=True)
class BatchKernel:
    """A compiled batch; the generated module documents `run`."""

    kernel: Kernel
    module: ModuleType
    run: Callable[..., None]

    @cached_property
    def address(self) -> int:
        """Address of the kernel's `run`."""
        return address_of(self.kernel.run)

    @cached_property
    def fixed_positions(self) -> IntArray:
        """Positions of numbers that are constant in a run: constants and the filter's table, without derivatives."""
        m = self.module
        rows, size = int(m.AT_TABLE) + int(m.PROP) * np.arange(int(m.TERMS) + 2), int(m.NF) * int(m.WIDTH)
        of_table = rows[:, np.newaxis] + np.arange(size)
        return np.concatenate([_places(m, "C"), int(m.AT_REGULAR) + np.arange(size), of_table.ravel()])

    @cached_property
    def states(self) -> IntArray:
        """Positions of the numbers that describe the state of a run."""
        return np.concatenate([_places(self.module, name) for name in ("X", "Z", "TIME")])


@lru_cache(maxsize=64)
def batch_kernel_for(kernel: Kernel) -> BatchKernel:
    """Return the compiled batch of a kernel, from the cache if it has been compiled before.

    Raises
    ------
    UsageError
        The cache cannot be written to.
    """
    # The batch imports its kernel, so the kernel's name and text are part of the hash.
    name = f"batch_{fingerprint(kernel.module.__name__ + kernel.text)}"
    module = compiled_module(name, lambda: generate(kernel.text, kernel.module), partial(_call_once, kernel=kernel))
    return BatchKernel(kernel, module, module.run_batch)


@dataclass(frozen=True)
class BatchBuffers:
    """Arrays that a batch run reads and writes, with `SETS` rows for data that each set has of its own.

    Attributes
    ----------
    address : int
        Address of the kernel's `run`.
    p : (SETS, n_p)
    grids : (SETS, 4)
    owns, ones : (SETS, DISCRETE), (SETS, SIZE)
        Integers and workspace of each set, laid out as in its kernel.
    statuses : (SETS,)
    discrete, w : (DISCRETE_SETS,), (PLACES SETS,)
    events : (SETS, n_events)
    """

    address: int
    p: FloatArray
    grids: FloatArray
    owns: IntArray
    ones: FloatArray
    statuses: IntArray
    discrete: IntArray
    w: FloatArray
    events: FloatArray

    def copy_constants(self, batch: BatchKernel) -> None:
        """Copy the constant numbers of each set from the workspaces of runs that have begun."""
        m, together = batch.module, self.w.reshape(-1, SETS)
        # Transposed: the sets' values of one number stand side by side.
        together[batch.fixed_positions] = self.ones[:, batch.fixed_positions].T
        for place, name in (("START", "START"), ("INTERVAL", "INTERVAL"), ("STEP", "STEP"), ("STEP_CLOSE", "CLOSE")):
            together[int(getattr(m, place))] = self.grids[:, int(getattr(m, f"GRID_{name}"))]
        self.discrete[int(m.NEXT)] = self.owns[0, int(m.NEXT_SAMPLE)]

    def arguments(self, times: FloatArray, values: FloatArray, y: FloatArray) -> tuple[int | NDArray[np.generic], ...]:
        """Return the arguments of `run`, given the edges' times and values and the outputs, (SETS n n_y,)."""
        directions = np.zeros(0)
        own = (self.owns.ravel(), self.ones.ravel(), self.statuses, self.discrete, self.w)
        grids, events = self.grids.ravel(), self.events.ravel()
        return (self.address, self.p.ravel(), directions, grids, times, values, *own, y, events)


def allocate_batch(batch: BatchKernel, *, events: int) -> BatchBuffers:
    """Return buffers of a batch that has not begun; `events` is the length of each set's log of switches."""
    return _buffers(batch.module, batch.address, events)


def _buffers(module: ModuleType, address: int, events: int) -> BatchBuffers:
    size = int(module.SIZE)
    return BatchBuffers(
        address=address,
        p=np.ones((SETS, int(module.NP))),
        grids=np.tile([0.0, 1e-4, 1e-4, 1e-4], (SETS, 1)),
        owns=np.zeros((SETS, int(module.DISCRETE)), dtype=np.int64),
        ones=aligned_zeros(SETS * size).reshape(SETS, size),
        statuses=np.zeros(SETS, dtype=np.int64),
        discrete=np.zeros(int(module.DISCRETE_SETS), dtype=np.int64),
        w=aligned_zeros(int(module.PLACES) * SETS),
        events=np.zeros((SETS, events)),
    )


def _places(module: ModuleType, part: str) -> IntArray:
    return np.arange(int(getattr(module, f"AT_{part}")), int(getattr(module, f"END_{part}")))


def _call_once(module: ModuleType, kernel: Kernel) -> None:
    """Call the entry point once without samples, so that later calls find it compiled."""
    module.run_batch(*_buffers(module, address_of(kernel.run), 0).arguments(np.zeros(0), np.zeros(0), np.zeros(0)))
