"""The problems of the benchmarks: values, step edges and records, shared by every peer.

A step edge comes at the instant the integral of the commanded rate reaches ``k / n``. Both command
laws used here have it in closed form, so that no peer loses accuracy to a root finder.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

SAMPLE_TIME = 1.0e-4
"""Sampling interval of every record, in s."""

PARAMETERS = (
    "stepper.coil_resistance",
    "stepper.coil_inductance",
    "stepper.torque_constant",  # k_v is tied to it
    "friction.static",
    "stepper.detent.0.cos",  # K cos(phi), K sin(phi): the coordinates of the search
    "stepper.detent.0.sin",
    "stepper.detent.1.cos",
    "stepper.detent.1.sin",
    "friction.coulomb",
    "friction.viscous",
    "gear.stiffness",
    "gear.damping",
    "housing.gain",
    "housing.frequency",
    "housing.damping",
)
"""The estimated parameters, in the order of the Jacobian's columns.

The column after them belongs to the record's time offset; it is ``-dy/dt`` and needs no
sensitivity equation. Four columns in turn fill one AVX2 register of the reference.
"""


@dataclass(frozen=True, kw_only=True)
class Mechanism:
    """The plant of the benchmarks, in SI units; detents are ``(amplitude, phase)`` in N m, rad.

    The first detent has a period of 1.8 deg, the second one of 3.6 deg. The field names follow
    the mechanism file; the housing is of the form "paper".
    """

    name: str
    peak_voltage: float
    rotor_inertia: float
    coil_resistance: float
    coil_inductance: float
    torque_constant: float
    detents: tuple[tuple[float, float], tuple[float, float]]
    static: float
    coulomb: float
    viscous: float
    gear_ratio: float
    stiffness: float
    damping: float
    load_inertia: float
    housing_gain: float
    housing_frequency: float
    housing_damping: float
    poles: int = 100

    def estimated(self) -> np.ndarray:
        """Return the values of `PARAMETERS`, shape (15,)."""
        detents = [K * f(phi) for K, phi in self.detents for f in (math.cos, math.sin)]
        values = [self.coil_resistance, self.coil_inductance, self.torque_constant, self.static]
        values += [*detents, self.coulomb, self.viscous, self.stiffness, self.damping]
        return np.array([*values, self.housing_gain, self.housing_frequency, self.housing_damping])

    def constants(self) -> np.ndarray:
        """Return p/2, J_rot, G and J_m, shape (4,)."""
        return np.array([self.poles / 2, self.rotor_inertia, self.gear_ratio, self.load_inertia], float)


PAPER = Mechanism(
    name="paper",
    peak_voltage=5.7,
    rotor_inertia=8.9e-6,
    coil_resistance=9.9,
    coil_inductance=0.045,
    torque_constant=0.384,
    detents=((0.0047, math.radians(35.0)), (0.0231, math.radians(-110.0))),
    static=0.008,
    coulomb=0.0013,
    viscous=0.0061,
    gear_ratio=50.0,
    stiffness=913.47,
    damping=0.39,
    load_inertia=0.010534,
    housing_gain=4.6,
    housing_frequency=5578.0,
    housing_damping=0.095,
)
"""The values estimated by Kornienko et al. (2013); supply voltage and detent phases are ours."""

LIGHTLY_DAMPED = Mechanism(
    name="lightly damped",
    peak_voltage=5.7,
    rotor_inertia=8.9e-6,
    coil_resistance=9.490935494162924,
    coil_inductance=0.04973572630745655,
    torque_constant=0.2978555962432685,
    detents=(
        (0.00988548935820029, math.radians(-39.20946964589017)),
        (0.02200761976901297, math.radians(-22.36252567579242)),
    ),
    static=0.009626982573084707,
    coulomb=0.0027440165521545813,
    viscous=0.0010088837714198285,
    gear_ratio=50.0,
    stiffness=1544.4999085359395,
    damping=0.3405687619233034,
    load_inertia=0.010534,
    housing_gain=3.400008369928954,
    housing_frequency=4932.516802301947,
    housing_damping=0.05550916391234485,
)
"""A mechanism with a sixth of the viscous friction: it rings between steps, and sticks often."""


@dataclass(frozen=True, kw_only=True)
class Problem:
    """One record to simulate: a mechanism, its command and the samples wanted.

    Parameters
    ----------
    name : str
        Name of the record.
    mechanism : Mechanism
        The plant.
    start_angle : float
        Electrical angle theta_0 in rad; the rotor starts at ``theta_0 / (p / 2)``.
    n_samples : int
        Number of samples, the first one at time 0.
    edge_times : numpy.ndarray
        Instants of the step edges in s, ascending, shape (n_edges,), inside the record.
    edge_angles : numpy.ndarray
        Electrical angle in rad before the first edge and after each, shape (n_edges + 1,).
    """

    name: str
    mechanism: Mechanism
    start_angle: float
    n_samples: int
    edge_times: np.ndarray
    edge_angles: np.ndarray

    @property
    def duration(self) -> float:
        """Time of the last sample, in s."""
        return (self.n_samples - 1) * SAMPLE_TIME

    @cached_property
    def voltages(self) -> np.ndarray:
        """Coil voltages u_A, u_B in V before the first edge and after each, shape (n_edges + 1, 2)."""
        phasor = np.array([-np.cos(self.edge_angles), np.sin(self.edge_angles)])
        return np.ascontiguousarray(self.mechanism.peak_voltage * phasor.T)


def constant_rate(mechanism: Mechanism, rate: float, *, microsteps: int = 1, start_angle_deg: float = 0.0) -> Problem:
    """Return 1 s of stepping at `rate` full steps/s."""
    edges = np.arange(1, math.ceil(microsteps * rate)) / (microsteps * rate)
    kind = "full" if microsteps == 1 else "micro"
    return _problem(f"{kind} {rate:g}", mechanism, edges, 1.0, microsteps, start_angle_deg)


def sweep(mechanism: Mechanism, *, duration: float = 60.0) -> Problem:
    """Return the 16-microstep sweep from 0 at 2 full steps/s per s; 120 full steps/s after 60 s.

    The integral of the rate is ``t**2``, so microstep k comes at ``sqrt(k) / 4``.
    """
    edges = np.sqrt(np.arange(1, math.ceil(16 * duration**2))) / 4.0
    return _problem("sweep", mechanism, edges, duration, 16, 0.0)


def first_seconds(problem: Problem, duration: float) -> Problem:
    """Return the beginning of `problem`, in s."""
    edges = problem.edge_times[problem.edge_times < duration]
    return replace(
        problem,
        n_samples=round(duration / SAMPLE_TIME) + 1,
        edge_times=edges,
        edge_angles=problem.edge_angles[: len(edges) + 1],
    )


def start_state(problem: Problem) -> np.ndarray:
    """Return i_A, i_B, alpha, omega, alpha_g, omega_g, z, z' of the start, shape (8,).

    At rest, currents settled, the rotor as commanded, the gear unwound.
    """
    i_A, i_B = problem.voltages[0] / problem.mechanism.coil_resistance
    alpha = problem.start_angle / (problem.mechanism.poles / 2)
    return np.array([i_A, i_B, alpha, 0.0, alpha / problem.mechanism.gear_ratio, 0.0, 0.0, 0.0])


def _problem(
    name: str,
    mechanism: Mechanism,
    edges: np.ndarray,
    duration: float,
    microsteps: int,
    start_angle_deg: float,
) -> Problem:
    start = math.radians(start_angle_deg)
    angles = start + np.arange(len(edges) + 1) * (0.5 * math.pi / microsteps)
    return Problem(
        name=name,
        mechanism=mechanism,
        start_angle=start,
        n_samples=round(duration / SAMPLE_TIME) + 1,
        edge_times=edges,
        edge_angles=angles,
    )


class Output(NamedTuple):
    """What a peer returns.

    Attributes
    ----------
    torque : numpy.ndarray
        Measured torque y in N m, shape (n,).
    first : int
        Index of its first sample in the record; a slow peer runs on a window.
    jacobian : numpy.ndarray or None
        Derivative of `torque` by `PARAMETERS`, shape (n, 15), where it was kept.
    """

    torque: np.ndarray
    first: int = 0
    jacobian: np.ndarray | None = None


Run = Callable[[], Output]
"""What a peer's `prepare(problem, jacobian=..., keep_jacobian=...)` returns; only this is timed.

All that depends on the structure alone (compiling, loading) belongs to `prepare`. The Jacobian must
be computed by every timed run; it is kept, for its accuracy, only in a run that is not timed.
"""


def mean_voltages(problem: Problem) -> np.ndarray:
    """Return the voltages' mean over each sampling interval, shape (n_samples - 1, 2), in V.

    The best that a peer without edges can be given.
    """
    grid = np.arange(problem.n_samples) * SAMPLE_TIME
    times = np.concatenate([[0.0], problem.edge_times, [problem.duration]])
    passed = np.zeros((len(times), 2))
    passed[1:] = np.cumsum(np.diff(times)[:, None] * problem.voltages, axis=0)
    integral = np.array([np.interp(grid, times, column) for column in passed.T])
    return np.ascontiguousarray(np.diff(integral, axis=1).T / SAMPLE_TIME)
