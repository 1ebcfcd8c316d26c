"""Choice of the number of integration steps per sample from the promised accuracy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import Timing
from mechid.signal.stored_series import WritableSeries, allocate_series
from mechid.simulation.shared_runs import SHARED_RUNS, Blocks
from mechid.simulation.simulator import ON_TIME, Run, Simulator, trajectory_of
from mechid.simulation.trajectory import SimulationOutcome, Trajectory

SUBSTEPS = (1, 2, 4, 8)
PROMISE = 1e-5
"""Promised RMS error, relative to the record's RMS torque."""
ENOUGH = 0.1 * PROMISE


def simulate_accurately(simulator: Simulator, p: FloatArray, *, timing: Timing = ON_TIME) -> Trajectory:
    """Simulate without sensitivities, with so many steps per sample that doubling them would not change the result.

    The step counts 1, 2, 4 and 8 are tried in turn until the result differs from that of twice the steps by at most
    `ENOUGH`. The finer result is returned; its error is about fifteen times smaller than the difference. If a switch
    falls either way within rounding, no step count suffices and `difference` stays large.

    Parameters
    ----------
    simulator : Simulator
    p : (n,)
        The kernel's parameters.
    timing : Timing
    """
    y, run, difference = accurate_outputs(simulator, p, timing=timing)
    return replace(trajectory_of(run, y), difference=difference)


def accurate_outputs(
    simulator: Simulator, p: FloatArray, *, timing: Timing = ON_TIME
) -> tuple[tuple[WritableSeries, ...], Run, float | None]:
    """Return the plant's outputs, n samples each, with the step count of `simulate_accurately`.

    Also return their run and its difference. Each run overwrites the one with half as many steps, so that the outputs
    are stored once.
    """
    y, none = tuple(allocate_series(simulator.base.samples) for _ in simulator.plant.outputs), np.zeros((p.size, 0))
    begun = partial(simulator.run, p, timing=timing, directions=none)
    # The fit that is predicted has often just been simulated with as few steps.
    coarse: Blocks = SHARED_RUNS.begin(simulator, p, timing=timing, substeps=SUBSTEPS[0])
    _write_outputs(y, coarse)
    for substeps in SUBSTEPS:
        run = begun(substeps=2 * substeps)
        change = _overwrite_outputs(y, run)
        # Runs that ended early cannot be compared.
        difference = change if coarse.outcome is run.outcome is SimulationOutcome.COMPLETE else None
        if difference is not None and difference <= ENOUGH:
            break
        coarse = run
    return y, run, difference


def _write_outputs(y: Sequence[WritableSeries], run: Blocks) -> None:
    """Write a run's outputs, n samples each."""
    for block in run.blocks():
        for one, values in zip(y, block.y.T, strict=True):
            one[block.start : block.stop] = values


def _overwrite_outputs(y: Sequence[WritableSeries], run: Run) -> float:
    """Overwrite outputs, n samples each, with those of a run and return the largest relative RMS change."""
    size, change = np.zeros(len(y)), np.zeros(len(y))
    for block in run.blocks():
        part = slice(block.start, block.stop)
        fine, before = block.y.T, np.stack([one[part] for one in y])
        with np.errstate(all="ignore"):  # where a run fails there is no change
            size += np.sum(fine**2, axis=1)
            change += np.sum((fine - before) ** 2, axis=1)
        for one, values in zip(y, fine, strict=True):
            one[part] = values
    return float(np.sqrt(np.divide(change, size, out=np.zeros(len(y)), where=size > 0.0)).max(initial=0.0))
