"""mechid's batch: eight parameter sets side by side in one kernel; what is timed is all eight."""

from __future__ import annotations

import numpy as np

from mechid.simulation.batch import SETS, Batch
from mechid.simulation.simulator import Simulator, TimeBase

from .mechid_side import command_of, directions_of, mechanism_of
from .problem import SAMPLE_TIME, Output, Problem, Run

NAME = "mechid, batch of eight"
REMARK = "eight sets, 0.1 % apart, one step a sample; a trajectory's share of the time"
TRAJECTORIES = SETS

SPREAD = 1e-3
"""Standard deviation of the sets around the problem's values, as a share of each."""


def prepare(problem: Problem, *, jacobian: bool, keep_jacobian: bool = False, substeps: int = 1) -> Run:
    """Return the run of eight sets, the first of them the problem's, whose torque it gives."""
    if jacobian or keep_jacobian:
        raise NotImplementedError("runs of a batch have no sensitivities")
    mechanism = mechanism_of(problem)
    simulator = Simulator(mechanism.plant, command_of(problem), TimeBase(1.0 / SAMPLE_TIME, problem.n_samples))
    points = mechanism.kernel_values() + moves(problem) @ directions_of(mechanism).T
    none = np.zeros((points.shape[1], 0))

    def run() -> Output:
        y = np.empty((SETS, problem.n_samples))
        runs = [simulator.run(p, substeps=substeps, directions=none) for p in points]
        for first, stop, outputs in Batch(runs).blocks():
            y[:, first:stop] = outputs[:, :, 0]
        return Output(y[0])

    run()
    return run


def moves(problem: Problem) -> np.ndarray:
    """Return how far each set's values of `problem.PARAMETERS` are from the problem's, (8, 15); the first is there."""
    shares = SPREAD * np.random.default_rng(1).standard_normal((SETS, len(problem.mechanism.estimated())))
    shares[0] = 0.0
    return shares * problem.mechanism.estimated()
