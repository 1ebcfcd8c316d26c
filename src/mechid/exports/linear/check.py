"""Verification of linear models against the nonlinear equations in the time domain.

The nonlinear equations are integrated over one period of a sine input, starting from a point on the linear response.
The result deviates from that response only through nonlinearity and errors in the matrices. No transient has to decay,
so loads without damping pose no difficulty. Half the difference between a sine and its negative cancels terms even in
the amplitude.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from mechid.arrays import FloatArray
from mechid.exports.linear.linearisation import HeldMechanism
from mechid.exports.linear.state_space import Matrices
from mechid.kernel.equations import equations_of
from mechid.simulation.linearisation import Linearised

FREQUENCIES_HZ = (10.0, 100.0)
SMALL = 1e-6
"""Largest deviation of a state during the period, in its SI unit."""
INSTANTS = 32
"""Compared instants per period."""
LEAST = 1e-6
"""Smallest response that is compared, relative to the largest, in SI units; smaller ones are below the integration
error."""


@dataclass(frozen=True, eq=False)
class _Driven:
    """Nonlinear equations about an equilibrium, with varying external inputs."""

    held: HeldMechanism
    about: Linearised
    kept: list[int]

    def outputs(self, x: FloatArray, place: int, w: float, times: FloatArray, size: float) -> FloatArray:
        """Return the outputs, (t, n_y), for an input size cos(w t), starting with deviations x of the states."""
        equations, rest = equations_of(self.held.plant), self.held.rest(self.about)

        def inputs(t: float) -> list[float]:
            u = self.about.inputs.copy()
            u[place] += size * np.cos(w * t)
            return list(u)

        still = equations.rates(self.about.x.tolist(), self.about.inputs.tolist(), *rest)

        def flow(t: float, off: FloatArray) -> FloatArray:
            return equations.rates((self.about.x + off).tolist(), inputs(t), *rest) - still

        start = np.zeros(self.about.x.size)
        start[self.kept] = x
        run = solve_ivp(flow, (0.0, times[-1]), start, method="DOP853", t_eval=times, rtol=1e-9, atol=1e-10 * SMALL)
        every = [
            self.held.outputs_at(self.about.x + off, inputs(t), rest) for t, off in zip(times, run.y.T, strict=True)
        ]
        return np.array(every)


def departure(held: HeldMechanism, name: str, matrices: Matrices) -> float:
    """Return the largest deviation of the outputs from the linear model, relative to the response.

    Parameters
    ----------
    held : HeldMechanism
    name : str
        Name of the model, which describes the state of friction.
    matrices : Matrices
        Matrices as read back from the file.
    """
    driven = _Driven(held, held.about(name), held.moving_states(name))
    ways = [(column, hz) for column in range(len(held.columns)) for hz in FREQUENCIES_HZ]
    return max((_departure(driven, matrices, *way) for way in ways), default=0.0)


def _departure(driven: _Driven, matrices: Matrices, column: int, frequency_hz: float) -> float:
    A, B, C, D = matrices.all
    w, times = 2.0 * np.pi * frequency_hz, np.linspace(0.0, 1.0 / frequency_hz, INSTANTS)
    x = np.linalg.solve(1j * w * np.eye(len(A)) - A, B[:, column] + 0j)
    y = C @ x + D[:, column]
    size = SMALL / float(np.abs(x).max(initial=SMALL))
    place = driven.held.columns[column]
    start = np.asarray(size * x.real, dtype=np.float64)
    # With opposite signs, terms even in the amplitude cancel in half the difference.
    ends = [driven.outputs(sign * start, place, w, times, sign * size) for sign in (1.0, -1.0)]
    off = np.abs((ends[0] - ends[1]) / 2.0 - size * (y * np.exp(1j * w * times)[:, None]).real).max(axis=0)
    counted = np.abs(y) > LEAST * np.abs(y).max()
    return float((off[counted] / (size * np.abs(y[counted]))).max(initial=0.0))
