"""Switches that a kernel has logged: all of them, or those at which outputs jump."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from types import ModuleType

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.simulation.trajectory import Switching


@dataclass(frozen=True)
class Jumps:
    """Samples in whose interval outputs jump; the recorded value of such a sample depends on the recorder.

    Attributes
    ----------
    samples : (m,)
        Index relative to the first sample of a block; a sample with several jumps occurs several times.
    since : (m,)
        Fraction of the sample interval from the jump to the sample, 0 to 1.
    rises : (m, n_y)
        Jump of each output.
    """

    samples: IntArray
    since: FloatArray
    rises: FloatArray

    def shift_by(self, samples: int) -> Jumps:
        """Return the jumps with sample indices relative to a sample that many samples before the block."""
        return replace(self, samples=self.samples + samples)


NO_JUMPS = Jumps(np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros((0, 0)))


def concatenate_jumps(parts: Sequence[Jumps]) -> Jumps:
    """Concatenate the jumps of several blocks, all relative to one sample."""
    there = [part for part in parts if part.samples.size]
    if not there:
        return NO_JUMPS
    return Jumps(*(np.concatenate([getattr(part, f.name) for part in there]) for f in fields(Jumps)))


def logged_switches(module: ModuleType, events: FloatArray, discrete: IntArray, directions: int) -> Switching:
    """Return the switches that a kernel has logged, with derivatives of their instants along the directions."""
    table = _table(module, events, discrete)
    switch, before, after = (
        table[:, int(getattr(module, f"EVENT_{name}"))].astype(np.int64) for name in ("SWITCH", "BEFORE", "AFTER")
    )
    lanes = int(module.EVENT_LANES)
    times, slopes = table[:, int(module.EVENT_TIME)].copy(), table[:, int(module.EVENT_SLOPE)].copy()
    return Switching(times, switch, before, after, slopes, table[:, lanes : lanes + directions].copy())


def take_logged_jumps(
    module: ModuleType,
    events: FloatArray,
    discrete: IntArray,
    switches: Sequence[int],
    begin_s: float,
    interval_s: float,
    samples: int,
) -> Jumps:
    """Return the jumps at given switches that a kernel has logged in a block, and clear its log.

    Parameters
    ----------
    module : ModuleType
        The kernel's module, which defines the layout.
    events, discrete : arrays
        As passed to the kernel's `run`.
    switches : sequence of int
        Indices, in the plant, of the switches to include.
    begin_s, interval_s : float
        Instant of the block's first sample, and the sample interval, s.
    samples : int
        Number of samples in the block.
    """
    if not discrete[int(module.EVENTS)]:
        return NO_JUMPS
    table = _table(module, events, discrete)
    discrete[int(module.EVENTS)] = 0
    instants = (table[:, int(module.EVENT_TIME)] - begin_s) / interval_s
    # A switch at a sample instant, up to rounding, belongs to that sample and not to the next.
    at = np.ceil(instants - 1e-9).astype(np.int64)
    counts = np.isin(table[:, int(module.EVENT_SWITCH)].astype(np.int64), switches)
    within = counts & (at >= 0) & (at < samples)
    since = np.clip(at - instants, 0.0, 1.0)[within]
    return Jumps(at[within], since, table[within, int(module.EVENT_RISE) : int(module.EVENT_LANES)].copy())


def _table(module: ModuleType, events: FloatArray, discrete: IntArray) -> FloatArray:
    """Return one row per logged switch, at most as many as the log has room for."""
    return events.reshape(-1, int(module.EVENT_LANES) + int(module.NL))[: discrete[int(module.EVENTS)]]
