"""As many integration steps a sample as the promised accuracy needs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mechid.simulation.simulator import Simulator, simulate_run
from mechid.simulation.trajectory import SimulationOutcome, Trajectory

FloatArray = NDArray[np.float64]

SUBSTEPS = (1, 2, 4, 8)
PROMISE = 1e-5
"""RMS error that is promised, relative to the record's RMS torque."""
ENOUGH = 0.1 * PROMISE


def simulate_accurately(simulator: Simulator, p: FloatArray, *, time_offset_s: float = 0.0) -> Trajectory:
    """Return the run with so many steps a sample that twice as many would not change it.

    Tried are 1, 2, 4 and 8; the first that differs from its double by at most `ENOUGH` will do, and it
    is the double that is returned, whose error is some fifteen times smaller than the difference. Where
    a switch falls either way within rounding no number is enough: `difference` then stays large.

    Parameters
    ----------
    simulator : Simulator
    p : (n,)
        The kernel's parameters.
    time_offset_s : float
        Shifts the command, s.
    """
    coarse = simulate_run(simulator.run(p, time_offset_s=time_offset_s, substeps=SUBSTEPS[0]))
    for substeps in SUBSTEPS:
        fine = simulate_run(simulator.run(p, time_offset_s=time_offset_s, substeps=2 * substeps))
        fine = replace(fine, difference=_difference(coarse, fine))
        if fine.difference is not None and fine.difference <= ENOUGH:
            break
        coarse = fine
    return fine


def _difference(coarse: Trajectory, fine: Trajectory) -> float | None:
    """Return the relative RMS difference of the worst output, None where either failed."""
    if not coarse.outcome is fine.outcome is SimulationOutcome.COMPLETE:
        return None
    return max(_relative(coarse.values[quantity], values) for quantity, values in fine.values.items())


def _relative(coarse: FloatArray, fine: FloatArray) -> float:
    size = float(np.linalg.norm(fine))
    return float(np.linalg.norm(fine - coarse)) / size if size > 0.0 else 0.0
