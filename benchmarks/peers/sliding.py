"""A window of the sweep in which the rotor never stops, and its equations, for solvers that search no switches.

The states are scaled to about one, so that one tolerance suits all of them; the angle counts from the nearest
electrical period, the gear's state is its wind-up. All that depends on the parameters alone is worked out before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from . import reference_c
from .problem import SAMPLE_TIME, Problem, first_seconds

STATES = ("i_A", "i_B", "alpha", "omega", "delta", "v", "z", "z_dot")
CURRENT, ANGLE, SPEED, HOUSING, HOUSING_RATE = 0.5, 0.03, 5.0, 0.1, 500.0
SCALE = np.array([CURRENT, CURRENT, ANGLE, SPEED, ANGLE, SPEED, HOUSING, HOUSING_RATE])
"""Size of each state, in SI units."""

OMEGA = STATES.index("omega")
COEFFICIENTS = (
    *("supply", "loss", "emf", "torque", "sin_4", "cos_4", "sin_2", "cos_2", "coulomb", "viscous", "spring", "damper"),
    *("load_spring", "load_damper", "force", "stiffness", "damping", "angle", "spring_out", "damper_out"),
)
IN_RATES = COEFFICIENTS[:-2]
INSTANT = 1e-12
"""A sample so near a step edge is at it, in s."""


@dataclass(frozen=True)
class Window:
    """A window of a record, from the state that the truth has at its start.

    Attributes
    ----------
    problem : Problem
        The record.
    first, last : int
        Indices of the window's samples.
    """

    problem: Problem
    first: int
    last: int

    @cached_property
    def samples(self) -> np.ndarray:
        """Times of the samples in s, shape (last - first + 1,)."""
        return np.arange(self.first, self.last + 1) * SAMPLE_TIME

    @cached_property
    def _inside(self) -> np.ndarray:
        times = self.problem.edge_times
        return np.flatnonzero((times > self.samples[0]) & (times < self.samples[-1]))

    @cached_property
    def borders(self) -> np.ndarray:
        """Start, step edges and end in s; between two of them the voltages are held."""
        return np.concatenate([self.samples[:1], self.problem.edge_times[self._inside], self.samples[-1:]])

    @cached_property
    def voltages(self) -> np.ndarray:
        """Coil voltages of each piece in V, shape (len(borders) - 1, 2)."""
        return self.problem.voltages[self._inside[0] : self._inside[-1] + 2]

    @cached_property
    def grids(self) -> list[np.ndarray]:
        """Times of each piece: its start, the samples inside, its end."""
        inside = [
            self.samples[(self.samples > start + INSTANT) & (self.samples < stop - INSTANT)]
            for start, stop in pairwise(self.borders)
        ]
        ends = zip(self.borders[:-1], inside, self.borders[1:], strict=True)
        return [np.concatenate([[start], samples, [stop]]) for start, samples, stop in ends]

    @cached_property
    def times(self) -> np.ndarray:
        """Start, step edges and samples in s, those of all pieces one after another, each once."""
        return np.concatenate([self.borders[:1], *(grid[1:] for grid in self.grids)])

    @cached_property
    def kept(self) -> np.ndarray:
        """Indices of the samples among the `times`."""
        return np.searchsorted(self.times, self.samples - INSTANT)

    @cached_property
    def before(self) -> reference_c.Trajectory:
        """The truth up to the window's start."""
        return reference_c.truth(first_seconds(self.problem, self.samples[0]))

    @cached_property
    def start(self) -> np.ndarray:
        """The scaled state at the first sample, shape (8,)."""
        i_A, i_B, alpha, omega, alpha_g, omega_g, z, z_dot = self.before.final
        half_poles, _, G, _ = self.problem.mechanism.constants()
        period = 2.0 * np.pi / half_poles
        angle = alpha - period * np.round(alpha / period)
        return np.array([i_A, i_B, angle, omega, alpha - G * alpha_g, omega - G * omega_g, z, z_dot]) / SCALE

    def coefficients(self, estimated: np.ndarray) -> dict[str, float]:
        """Return the numbers of the scaled equations for values of `problem.PARAMETERS`, shape (15,)."""
        R, L, k, _, d1c, d1s, d2c, d2s, T_frd, T_visc, K_s, D, K_res, w0, zeta = estimated
        half_poles, J_rot, G, J_m = self.problem.mechanism.constants()
        per_torque = 1.0 / (J_rot * SPEED)
        values = {
            "supply": 1.0 / (L * CURRENT),
            "loss": R / L,
            "emf": k * SPEED / (L * CURRENT),
            "torque": k * CURRENT * per_torque,
            "sin_4": d1c * per_torque,
            "cos_4": d1s * per_torque,
            "sin_2": d2c * per_torque,
            "cos_2": d2s * per_torque,
            "coulomb": self.before.mode * T_frd * per_torque,
            "viscous": T_visc / J_rot,
            "spring": K_s * ANGLE / G**2 * per_torque,
            "damper": D / (G**2 * J_rot),
            "load_spring": K_s * ANGLE / (J_m * SPEED),
            "load_damper": D / J_m,
            "force": w0**2 * K_res / (per_torque * HOUSING_RATE),
            "stiffness": w0**2 * HOUSING / HOUSING_RATE,
            "damping": 2.0 * zeta * w0,
            "angle": half_poles * ANGLE,
            "spring_out": K_s * ANGLE / G,
            "damper_out": D * SPEED / G,
        }
        return {name: values[name] for name in COEFFICIENTS}

    def checked(self, omega: np.ndarray) -> None:
        """Raise ArithmeticError if the rotor does not turn the one way at all samples: a switch, or NaN."""
        if not np.all(self.before.mode * omega > 0.0):
            raise ArithmeticError("the rotor stops in the window, or the solver does")


def rates(x: Any, u: Any, c: dict[str, Any], sin: Callable, cos: Callable) -> list[Any]:
    """Return the scaled states' rates; numbers and functions may be those of any tool."""
    i_A, i_B, alpha, omega, delta, v, z, z_dot = x
    sine, cosine = sin(c["angle"] * alpha), cos(c["angle"] * alpha)
    s2, c2 = 2.0 * sine * cosine, 1.0 - 2.0 * sine * sine
    detent = 2.0 * c["sin_4"] * s2 * c2 + c["cos_4"] * (1.0 - 2.0 * s2 * s2) + c["sin_2"] * s2 + c["cos_2"] * c2
    motor = c["torque"] * (i_A * sine + i_B * cosine)
    a = motor - detent - c["coulomb"] - c["viscous"] * omega - c["spring"] * delta - c["damper"] * v
    return [
        c["supply"] * u[0] - c["loss"] * i_A - c["emf"] * omega * sine,
        c["supply"] * u[1] - c["loss"] * i_B - c["emf"] * omega * cosine,
        SPEED / ANGLE * omega,
        a,
        SPEED / ANGLE * v,
        a - c["load_spring"] * delta - c["load_damper"] * v,
        HOUSING_RATE / HOUSING * z_dot,
        c["force"] * a - c["stiffness"] * z - c["damping"] * z_dot,
    ]


def torque(x: Any, c: dict[str, Any]) -> Any:
    """Return the measured torque in N m of the scaled states, states first."""
    return -(HOUSING * x[6] + c["spring_out"] * x[4] + c["damper_out"] * x[5])
