"""Mechanical equilibrium nearest to the commanded start, and its derivatives with respect to the parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
import sympy as sp

from mechid.arrays import FloatArray
from mechid.errors import FitError
from mechid.plant.plant import START_ANGLE, Plant


def equilibrium(plant: Plant, p: FloatArray, inputs: FloatArray, theta_0: float) -> tuple[FloatArray, FloatArray]:
    """Return the states at rest without friction, (n,), and their derivatives with respect to the parameters, (n, n_p).

    Newton's method on the rates starts from the commanded start; by the implicit function theorem
    dx/dp = -(df/dx)^-1 df/dp. Internal states of friction or of a cable, and the integrated inputs of measured
    channels, are undetermined at rest and keep their start values.

    Raises
    ------
    FitError
        There is no equilibrium within reach.
    """
    found = find_equilibrium(plant, p, inputs, theta_0)
    if found is None:
        raise FitError(
            f'no mechanical equilibrium near the start angle {np.degrees(theta_0):.6g} deg; use start = "commanded"'
        )
    return found


def find_equilibrium(
    plant: Plant, p: FloatArray, inputs: FloatArray, theta_0: float
) -> tuple[FloatArray, FloatArray] | None:
    """Return the result of `equilibrium`, or None if there is no equilibrium within reach."""
    found = _solve(plant, p.astype(np.float64).tobytes(), inputs.astype(np.float64).tobytes(), theta_0)
    return found and (found[0].copy(), found[1].copy())


# All records of a campaign start from the same few angles: Newton's method runs once for each.
@lru_cache(maxsize=64)
def _solve(plant: Plant, values: bytes, held: bytes, theta_0: float) -> tuple[FloatArray, FloatArray] | None:
    """Return the result of `equilibrium` for parameters and inputs given as bytes, which are hashable; None if none."""
    p, inputs = np.frombuffer(values), np.frombuffer(held)
    start, rates, to_states, to_parameters = _functions(plant)
    moved = _determined_states(plant)
    x = np.asarray(start(*p, *inputs, theta_0), dtype=np.float64)
    for _ in range(50):
        f = np.asarray(rates(*x, *p, *inputs), dtype=np.float64)
        slopes = np.asarray(to_states(*x, *p, *inputs), dtype=np.float64)
        if not (np.isfinite(f).all() and np.isfinite(slopes).all()):
            break
        # Least squares: every rate is to vanish but not every state moves, so the system need not be square.
        move = np.linalg.lstsq(slopes[:, moved], -f, rcond=None)[0]
        x[moved] += move
        if np.max(np.abs(move)) <= 1e-14 * max(1.0, float(np.max(np.abs(x)))):
            # Rounding leftovers of a state that is exactly zero at rest.
            x[np.abs(x) < 1e-14 * np.max(np.abs(x))] = 0.0
            f_p = np.asarray(to_parameters(*x, *p, *inputs), dtype=np.float64)
            x_p = np.zeros((x.size, p.size))
            x_p[moved] = np.linalg.lstsq(slopes[:, moved], -f_p, rcond=None)[0]
            return x, x_p
    return None


@lru_cache(maxsize=16)
def _determined_states(plant: Plant) -> list[int]:
    """Return the indices of the states that an equilibrium determines."""
    remembered = {s for block in plant.blocks if block.switch for s in block.rates}
    states = set(plant.states)
    return [
        k
        for k, (s, rate) in enumerate(zip(plant.states, plant.rates, strict=True))
        if s not in remembered and plant.expand(rate).free_symbols & states
    ]


@lru_cache(maxsize=16)
def _functions(plant: Plant) -> tuple[Callable[..., object], ...]:
    """Compile the start, the frictionless rates and their derivatives as functions of (states,) parameters, inputs."""
    ideal = {symbol: value for s in plant.switches for symbol, value in s.ideal.items()}
    rates = [plant.expand(e).subs(ideal) for e in plant.rates]
    common = (*plant.parameters, *plant.inputs)
    arguments = (*plant.states, *common)
    return (
        sp.lambdify((*common, START_ANGLE), list(plant.initial), modules="math"),
        sp.lambdify(arguments, rates, modules="math"),
        sp.lambdify(arguments, _slopes(rates, plant.states), modules="math"),
        sp.lambdify(arguments, _slopes(rates, plant.parameters), modules="math"),
    )


def _slopes(expressions: Sequence[sp.Expr], symbols: Sequence[sp.Symbol]) -> list[list[sp.Expr]]:
    """Return the derivatives of expressions, most of which hold few of the symbols."""
    return [[sp.diff(e, s) if s in e.free_symbols else sp.S.Zero for s in symbols] for e in expressions]
