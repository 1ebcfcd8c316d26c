"""Initial states of a record off the commanded rest, with derivatives with respect to parameters and start."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from mechid.arrays import FloatArray
from mechid.plant.plant import START_ANGLE, Plant

NEWTON_STEPS = 4
"""Number of Gauss-Newton steps; a kinematic error is small against its angle, so the first step does nearly all."""


@dataclass(frozen=True, eq=False)
class OwnStart:
    """Initial states of a record that does not start at rest.

    Attributes
    ----------
    off : (n_x,)
        Offsets of the plant's states from the start at rest.
    off_by_parameter : (n_x, n_p)
        Derivatives of `off` with respect to the parameters.
    filter : (n_f,)
        States of the filter, which are zero at rest.
    by_start : (n_x + n_f, n_s)
        Derivatives of the states of plant and filter with respect to the start values of the record, in the order of
        `Plant.starts`.
    """

    off: FloatArray
    off_by_parameter: FloatArray
    filter: FloatArray
    by_start: FloatArray


def own_start(plant: Plant, p: FloatArray, inputs: FloatArray, theta_0: float, values: Mapping[str, float]) -> OwnStart:
    """Return the initial states for a record's start values.

    Parameters
    ----------
    plant : Plant
    p : (n_p,)
    inputs : (n_u,)
        Held at the start.
    theta_0 : float
        Commanded electrical angle at the start, rad.
    values : mapping of str to float
        By the keys of `Plant.starts`; missing keys are zero.
    """
    states, to_parameters, to_start = _functions(plant)
    n = len(plant.states)
    # Only the offset from rest is used: the run itself supplies the rest, commanded or at equilibrium.
    own, rest = [values.get(key, 0.0) for key in plant.starts], [0.0] * len(plant.starts)
    at, at_rest = (np.array(states(*p, *inputs, theta_0, *v), dtype=np.float64) for v in (own, rest))
    moved, unmoved = (
        np.array(to_parameters(*p, *inputs, theta_0, *v), dtype=np.float64).reshape(n, p.size) for v in (own, rest)
    )
    slopes = np.array(to_start(*p, *inputs, theta_0, *own), dtype=np.float64)
    return OwnStart((at - at_rest)[:n], moved - unmoved, at[n:], slopes.reshape(at.size, len(own)))


def off_rest(plant: Plant, p: FloatArray, inputs: FloatArray, theta_0: float, states: FloatArray) -> dict[str, float]:
    """Return the start values of a record that lead to given states, (n_x + n_f,), by the keys of `Plant.starts`.

    Offsets count from the commanded rest. Gauss-Newton, since a kinematic error is not linear in its angle.
    """
    at, _, by_start = _functions(plant)
    own = np.zeros(len(plant.starts))
    for _ in range(NEWTON_STEPS):
        there = np.array(at(*p, *inputs, theta_0, *own), dtype=np.float64)
        slopes = np.array(by_start(*p, *inputs, theta_0, *own), dtype=np.float64).reshape(there.size, own.size)
        own = own + np.linalg.lstsq(slopes, states - there, rcond=None)[0]
    return dict(zip(plant.starts, own.tolist(), strict=True))


@lru_cache(maxsize=16)
def _functions(plant: Plant) -> tuple[Callable[..., list[float]], ...]:
    """Compile the initial states and their derivatives with respect to parameters (plant's states only) and start."""
    own = [sp.Symbol(d.symbol) for d in plant.starts.values()]
    at = [sp.sympify(plant.start_expressions.get(s, 0)) for s in plant.states_with_filter]
    arguments = (*plant.parameters, *plant.inputs, START_ANGLE, *own)
    by_parameter = [[sp.diff(e, q) for q in plant.parameters] for e in at[: len(plant.states)]]
    by_start = [[sp.diff(e, s) for s in own] for e in at]
    return tuple(sp.lambdify(arguments, e, modules="math", cse=True) for e in (at, by_parameter, by_start))
