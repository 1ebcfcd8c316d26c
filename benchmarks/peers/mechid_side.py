"""mechid's own side of the benchmark, one integration step a sample."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from mechid.campaign import mechanism_from_table
from mechid.command import Command, RateProfile
from mechid.identification.output_error.problem import Problem as FitProblem
from mechid.identification.output_error.reduction import channel_triangles
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.plant.mechanism import Mechanism
from mechid.simulation.simulator import Simulator, TimeBase, excitation_over

from .problem import PARAMETERS, SAMPLE_TIME, Output, Problem, Run

NAME = "mechid"
REMARK = "kernel as generated, one step a sample"
SUBSTEPS = 1


def prepare(problem: Problem, *, jacobian: bool, keep_jacobian: bool = False, substeps: int = SUBSTEPS) -> Run:
    """Return the run over the whole record, compiled and loaded, its edges found: the peers are given theirs."""
    mechanism = mechanism_of(problem)
    base = TimeBase(1.0 / SAMPLE_TIME, problem.n_samples)
    simulator = Simulator(mechanism.plant, command_of(problem), base, capacity=len(PARAMETERS))
    directions = directions_of(mechanism) if jacobian else None
    run = partial(run_mechid, simulator, mechanism, directions, keep_jacobian=keep_jacobian, substeps=substeps)
    run()
    return run


def run_mechid(
    simulator: Simulator, mechanism: Mechanism, directions: np.ndarray | None, *, keep_jacobian: bool, substeps: int
) -> Output:
    """Simulate; a call is what is timed.

    The Jacobian to the fifteen parameters and dy/dt are computed block by block, as the fit does it.
    """
    n = simulator.base.samples
    run = simulator.run(mechanism.kernel_values(), substeps=substeps, directions=directions)
    y = np.empty(n)
    kept = np.empty((n, len(PARAMETERS))) if keep_jacobian else None
    for block in run.blocks():
        y[block.start : block.stop] = block.y[:, 0]
        if kept is not None:
            kept[block.start : block.stop] = block.jacobian[:, 0, : len(PARAMETERS)]
    return Output(torque=y, jacobian=kept)


def prepare_reduction(problem: Problem) -> Callable[[], object]:
    """Return a run that simulates with the Jacobian and reduces it to the triangle of [Phi r J], as a fit does."""
    mechanism, command = mechanism_of(problem), command_of(problem)
    base = TimeBase(1.0 / SAMPLE_TIME, problem.n_samples)
    channel = TargetChannel("torque", np.zeros(problem.n_samples), 2e-3)
    target = Target("sweep", (channel,), base, command, excitation_over(command, base))
    fit = FitProblem(SearchSpace(mechanism), (target,), substeps=SUBSTEPS)
    return partial(channel_triangles, fit.model, target, fit.start, (0, problem.n_samples))


def command_of(problem: Problem) -> Command:
    """Return the sweep's command: 16 microsteps, 2 full steps/s per s."""
    end = problem.duration
    profile = RateProfile.through([(0.0, 0.0), (end, 2.0 * end)])
    return Command(stepping="micro", microsteps=16, rate=profile, start_angle_deg=math.degrees(problem.start_angle))


def mechanism_of(problem: Problem) -> Mechanism:
    """Return the problem's mechanism with the fifteen parameters free."""
    m = problem.mechanism
    detents = [
        {"period_deg": period, "amplitude": _free(K, 0.0, 1.0), "phase_deg": _free(math.degrees(phi), -180.0, 180.0)}
        for period, (K, phi) in zip((1.8, 3.6), m.detents, strict=True)
    ]
    stepper = {
        "poles": m.poles,
        "peak_voltage": m.peak_voltage,
        "rotor_inertia": m.rotor_inertia,
        "coil_resistance": _free(m.coil_resistance),
        "coil_inductance": _free(m.coil_inductance),
        "torque_constant": _free(m.torque_constant),
        "detent": detents,
    }
    friction = {"static": _free(m.static), "coulomb": _free(m.coulomb), "viscous": _free(m.viscous)}
    gear = {"ratio": m.gear_ratio, "stiffness": _free(m.stiffness), "damping": _free(m.damping)}
    housing = {
        "gain": _free(m.housing_gain),
        "frequency": _free(m.housing_frequency),
        "damping": _free(m.housing_damping),
    }
    load = {"inertia": m.load_inertia}
    table = {"stepper": stepper, "friction": friction, "gear": gear, "load": load, "housing": housing}
    return mechanism_from_table(table, "benchmark")


def _free(value: float, lower: float | None = None, upper: float | None = None) -> dict[str, float]:
    return {
        "value": value,
        "min": 0.1 * value if lower is None else lower,
        "max": 10.0 * value if upper is None else upper,
    }


def directions_of(mechanism: Mechanism) -> np.ndarray:
    """Return what each of `PARAMETERS` moves of the kernel's parameters, (n_p, 15)."""
    order = {str(s): i for i, s in enumerate(mechanism.plant.parameters)}
    slopes = mechanism.kernel_jacobian()
    pairs = {p.amplitude.removesuffix("amplitude"): p for p in mechanism.plant.polar_pairs}
    out = np.zeros((len(order), len(PARAMETERS)))
    for column, name in enumerate(PARAMETERS):
        pair = pairs.get(name.removesuffix("cos").removesuffix("sin"))
        if pair is None:
            out[:, column] = slopes[name]
        else:
            out[order[str(pair.cosine if name.endswith("cos") else pair.sine)], column] = 1.0
    return out
