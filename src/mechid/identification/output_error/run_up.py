"""Where records that begin in motion may begin: what the model does when it is stepped from some time before.

The states at the first sample are found by the fit; this is where the search for them begins. From rest at the
commanded angle a fit inside the first moments goes astray: it bends the mechanism to a start that is far off.
"""

from __future__ import annotations

import math
from collections.abc import Container

import numpy as np
from numpy.typing import NDArray

from mechid.campaign.campaign import is_of_start, mechanism_name
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.kernel.start import off_rest
from mechid.simulation.simulator import Simulator, TimeBase
from mechid.simulation.trajectory import SimulationOutcome

FloatArray = NDArray[np.float64]
STEPS, SHORTEST_S = 8.0, 0.3
"""Full steps before the first sample from which the model is stepped, and the shortest time that this may be."""


def run_up(problem: Problem, q: FloatArray, known: Container[str] = ()) -> FloatArray:
    """Return a point whose records in motion begin as the model there does, stepped from before.

    Records that begin at rest, and states whose names are `known`, stay as they are.
    """
    found = {name: v for t in problem.targets for name, v in _begun(problem, t, q).items()}
    values = {name: v for name, v in found.items() if name not in known}
    if not values:
        return q
    at = problem.coordinates
    own = zip(at.own_names, at.of_records(q), strict=True)
    moved = np.concatenate([at.of_mechanism(q), [values.get(name, v) for name, v in own]])
    return np.asarray(at.clip(moved))


def _begun(problem: Problem, target: Target, q: FloatArray) -> dict[str, float]:
    """Return the free states of a target's start by name; none where it begins at rest, or cannot be simulated."""
    free, command = [p for p in target.moved if is_of_start(p)], target.command
    if not free or command.begun_s <= 0.0:
        return {}
    wanted = max(SHORTEST_S, STEPS / max(abs(command.start_rate), 1e-9))
    samples = math.ceil(min(command.begun_s, wanted) * target.base.sample_rate_hz)
    before = samples * target.base.interval_s
    base = TimeBase(target.base.sample_rate_hz, samples + 1, command.begun_s - before)
    earlier = command.begun_at(command.begun_s - before)
    plant, p = problem.space.mechanism.plant, problem.coordinates.kernel(target, q)
    simulator = Simulator(plant, earlier, base, capacity=problem.coordinates.lanes)
    run = simulator.run(p, substeps=problem.substeps, directions=np.zeros((p.size, 0)))
    for _ in run.blocks():
        pass
    if run.outcome is not SimulationOutcome.COMPLETE:
        return {}
    found = off_rest(plant, p, target.excitation.initial, command.start_angle_rad, run.states)
    return {f.name: found[mechanism_name(f.name)] for f in free}
