"""What a kernel has noted of the switches it met: all of them, or those at which its outputs jump."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from types import ModuleType

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.simulation.trajectory import Switching


@dataclass(frozen=True)
class Jumps:
    """Samples in whose interval outputs jump: what is recorded of one depends on the recorder.

    Attributes
    ----------
    samples : (m,)
        Counted from the first of a block; one with several jumps is there several times.
    since : (m,)
        Share of the sample interval that has passed from the jump to the sample, 0 to 1.
    rises : (m, n_y)
        Of each output.
    """

    samples: IntArray
    since: FloatArray
    rises: FloatArray

    def later(self, samples: int) -> Jumps:
        """Return the same, counted from so many samples before the block."""
        return replace(self, samples=self.samples + samples)


NO_JUMPS = Jumps(np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros((0, 0)))


def joined(parts: Sequence[Jumps]) -> Jumps:
    """Return the jumps of several blocks, all counted from one sample."""
    there = [part for part in parts if part.samples.size]
    if not there:
        return NO_JUMPS
    return Jumps(*(np.concatenate([getattr(part, f.name) for part in there]) for f in fields(Jumps)))


def noted_switches(module: ModuleType, events: FloatArray, discrete: IntArray, directions: int) -> Switching:
    """Return the switches that a kernel has noted, with the derivatives of their instants along so many directions."""
    table = _table(module, events, discrete)
    switch, before, after = (
        table[:, int(getattr(module, f"EVENT_{name}"))].astype(np.int64) for name in ("SWITCH", "BEFORE", "AFTER")
    )
    lanes = int(module.EVENT_LANES)
    times, slopes = table[:, int(module.EVENT_TIME)].copy(), table[:, int(module.EVENT_SLOPE)].copy()
    return Switching(times, switch, before, after, slopes, table[:, lanes : lanes + directions].copy())


def noted_jumps(
    module: ModuleType,
    events: FloatArray,
    discrete: IntArray,
    switches: Sequence[int],
    begin_s: float,
    interval_s: float,
    samples: int,
) -> Jumps:
    """Return the jumps at some switches that a kernel has noted in a block, and let it forget what it has noted.

    Parameters
    ----------
    module : ModuleType
        The kernel's, which has the places.
    events, discrete : arrays
        As the kernel's `run` takes them.
    switches : sequence of int
        Those that count, by their number in the plant.
    begin_s, interval_s : float
        Instant of the block's first sample, and the time between two, s.
    samples : int
        Of the block.
    """
    if not discrete[int(module.EVENTS)]:
        return NO_JUMPS
    table = _table(module, events, discrete)
    discrete[int(module.EVENTS)] = 0
    instants = (table[:, int(module.EVENT_TIME)] - begin_s) / interval_s
    at = np.ceil(instants - 1e-9).astype(np.int64)
    counts = np.isin(table[:, int(module.EVENT_SWITCH)].astype(np.int64), switches)
    within = counts & (at >= 0) & (at < samples)
    since = np.clip(at - instants, 0.0, 1.0)[within]
    return Jumps(at[within], since, table[within, int(module.EVENT_RISE) : int(module.EVENT_LANES)].copy())


def _table(module: ModuleType, events: FloatArray, discrete: IntArray) -> FloatArray:
    """Return a row for each switch, of as many as there was room for."""
    return events.reshape(-1, int(module.EVENT_LANES) + int(module.NL))[: discrete[int(module.EVENTS)]]
