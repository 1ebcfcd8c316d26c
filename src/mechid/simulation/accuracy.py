"""As many integration steps a sample as the promised accuracy needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import Timing
from mechid.signal.stored import WritableSeries, allocate_series
from mechid.simulation.simulator import ON_TIME, Run, Simulator, trajectory_of
from mechid.simulation.trajectory import SimulationOutcome, Trajectory

SUBSTEPS = (1, 2, 4, 8)
PROMISE = 1e-5
"""RMS error that is promised, relative to the record's RMS torque."""
ENOUGH = 0.1 * PROMISE


def simulate_accurately(simulator: Simulator, p: FloatArray, *, timing: Timing = ON_TIME) -> Trajectory:
    """Return the run, without sensitivities, with so many steps a sample that twice as many would not change it.

    Tried are 1, 2, 4 and 8; the first that differs from its double by at most `ENOUGH` will do, and it
    is the double that is returned, whose error is some fifteen times smaller than the difference. Where
    a switch falls either way within rounding no number is enough: `difference` then stays large.

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
    """Return the plant's outputs alone, n samples each, as `simulate_accurately` chooses them.

    Also their run, and its difference. Each run is written over the one with half as many steps: outputs are kept once.
    """
    y, none = tuple(allocate_series(simulator.base.samples) for _ in simulator.plant.outputs), np.zeros((p.size, 0))
    begun = partial(simulator.run, p, timing=timing, directions=none)
    run = begun(substeps=SUBSTEPS[0])
    _written(y, run)
    for substeps in SUBSTEPS:
        coarse = run
        run = begun(substeps=2 * substeps)
        change = _written_over(y, run)
        difference = change if coarse.outcome is run.outcome is SimulationOutcome.COMPLETE else None
        if difference is not None and difference <= ENOUGH:
            break
    return y, run, difference


def _written(y: Sequence[WritableSeries], run: Run) -> None:
    """Write a run's outputs, n samples each."""
    for block in run.blocks():
        for one, values in zip(y, block.y.T, strict=True):
            one[block.start : block.stop] = values


def _written_over(y: Sequence[WritableSeries], run: Run) -> float:
    """Write a run's outputs over earlier ones, n samples each, and return the relative RMS change of the worst."""
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
