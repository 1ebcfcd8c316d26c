"""A batch's module on disk, compiled by Numba and cached beside its kernel's; and what a run of it needs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from mechid.arrays import FloatArray, IntArray
from mechid.kernel.batch.source import SETS, fingerprint, generate
from mechid.kernel.compiled import Kernel, aligned, compiled_module
from mechid.kernel.pointers import address_of


@dataclass(frozen=True)
class BatchKernel:
    """A compiled batch: `run` as the generated module documents it."""

    kernel: Kernel
    module: ModuleType
    run: Callable[..., None]

    @cached_property
    def address(self) -> int:
        """Where the kernel's `run` stands."""
        return address_of(self.kernel.run)

    @cached_property
    def fixed(self) -> IntArray:
        """Places of what never changes in a run: constants and the table of the filter, without its derivatives."""
        m = self.module
        rows, size = int(m.AT_TABLE) + int(m.PROP) * np.arange(int(m.TERMS) + 2), int(m.NF) * int(m.WIDTH)
        of_table = rows[:, np.newaxis] + np.arange(size)
        return np.concatenate([_places(m, "C"), int(m.AT_REGULAR) + np.arange(size), of_table.ravel()])

    @cached_property
    def states(self) -> IntArray:
        """Places of where a run stands."""
        return np.concatenate([_places(self.module, name) for name in ("X", "Z", "TIME")])


@lru_cache(maxsize=64)
def batch_kernel_for(kernel: Kernel) -> BatchKernel:
    """Return the compiled batch of a kernel, from the cache where it has been compiled before.

    Raises
    ------
    UsageError
        The cache cannot be written to.
    """
    name = f"batch_{fingerprint(kernel.module.__name__ + kernel.text)}"  # of which it imports
    module = compiled_module(name, lambda: generate(kernel.text, kernel.module), partial(_call_once, kernel=kernel))
    return BatchKernel(kernel, module, module.run_batch)


@dataclass(frozen=True)
class BatchBuffers:
    """All arrays that a run of a batch reads and writes; `SETS` rows where each set has its own.

    Attributes
    ----------
    address : int
        Of the kernel's `run`.
    p : (SETS, n_p)
    grids : (SETS, 4)
    owns, ones : (SETS, DISCRETE), (SETS, SIZE)
        Each set's own numbers and workspace, as its kernel has them.
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

    def meet(self, batch: BatchKernel) -> None:
        """Take over what never changes of each set, whose own workspaces are those of runs that have begun."""
        m, together = batch.module, self.w.reshape(-1, SETS)
        together[batch.fixed] = self.ones[:, batch.fixed].T
        for place, name in (("START", "START"), ("INTERVAL", "INTERVAL"), ("STEP", "STEP"), ("STEP_CLOSE", "CLOSE")):
            together[int(getattr(m, place))] = self.grids[:, int(getattr(m, f"GRID_{name}"))]
        self.discrete[int(m.NEXT)] = self.owns[0, int(m.NEXT_SAMPLE)]

    def arguments(self, times: FloatArray, values: FloatArray, y: FloatArray) -> tuple[int | NDArray[np.generic], ...]:
        """Return what `run` takes, with the edges' times and values and the outputs, (SETS n n_y,)."""
        directions = np.zeros(0)
        own = (self.owns.ravel(), self.ones.ravel(), self.statuses, self.discrete, self.w)
        grids, events = self.grids.ravel(), self.events.ravel()
        return (self.address, self.p.ravel(), directions, grids, times, values, *own, y, events)


def allocate_batch(batch: BatchKernel, *, events: int) -> BatchBuffers:
    """Return buffers of a batch that has not begun; so many numbers of each set's switches are kept."""
    return _buffers(batch.module, batch.address, events)


def _buffers(module: ModuleType, address: int, events: int) -> BatchBuffers:
    size = int(module.SIZE)
    return BatchBuffers(
        address=address,
        p=np.ones((SETS, int(module.NP))),
        grids=np.tile([0.0, 1e-4, 1e-4, 1e-4], (SETS, 1)),
        owns=np.zeros((SETS, int(module.DISCRETE)), dtype=np.int64),
        ones=aligned(SETS * size).reshape(SETS, size),
        statuses=np.zeros(SETS, dtype=np.int64),
        discrete=np.zeros(int(module.DISCRETE_SETS), dtype=np.int64),
        w=aligned(int(module.PLACES) * SETS),
        events=np.zeros((SETS, events)),
    )


def _places(module: ModuleType, part: str) -> IntArray:
    return np.arange(int(getattr(module, f"AT_{part}")), int(getattr(module, f"END_{part}")))


def _call_once(module: ModuleType, kernel: Kernel) -> None:
    """Call the entry point once on no samples, so that later calls find it compiled."""
    module.run_batch(*_buffers(module, address_of(kernel.run), 0).arguments(np.zeros(0), np.zeros(0), np.zeros(0)))
