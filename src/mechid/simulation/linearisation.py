"""Linearisation of a plant at rest: exact matrices, their parameter derivatives, and frequency responses.

About the mechanical equilibrium x* nearest to the commanded angle, with all inputs held,

    x' = A (x - x*) + B (u - u*),   y = y* + C (x - x*) + D (u - u*).

The mode of each switch there is a choice: friction holds, or is removed (`Holding`). A, B, C, D are the derivatives of
the symbolic equations; their parameter derivatives follow x* by the implicit function theorem.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, TypeAlias

import numpy as np
import sympy as sp

from mechid.arrays import ComplexArray, FloatArray
from mechid.command import Command, RateProfile
from mechid.kernel.equations import equations_of
from mechid.kernel.equilibrium import equilibrium
from mechid.plant.block import Switch
from mechid.plant.plant import Plant

Holding: TypeAlias = Mapping[sp.Symbol, float]
"""Value of each symbol that distinguishes the modes of the switches."""
Compiled: TypeAlias = Callable[..., list[Any]]


@dataclass(frozen=True, eq=False)
class Linearised:
    """A plant linearised about a rest point.

    Attributes
    ----------
    plant : Plant
    p : (n_p,)
        The kernel's parameters.
    x : (n,)
        The equilibrium: states of the plant, then of its filter.
    x_by_parameter : (n, n_p)
    inputs : (m,)
    holding : mapping of Symbol to float
        Modes of the switches.
    """

    plant: Plant
    p: FloatArray
    x: FloatArray
    x_by_parameter: FloatArray
    inputs: FloatArray
    holding: Holding

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states, (n,)."""
        return tuple(map(str, (*self.plant.states, *self.plant.filter.states)))

    @cached_property
    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """A (n, n), B (n, m), C (n_y, n) and D (n_y, m)."""
        found = _symbolic(self.plant).matrices(*self._arguments)
        return tuple(np.array(matrix, dtype=np.float64) for matrix in found)  # type: ignore[return-value]

    @cached_property
    def by_parameter(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Derivatives of A, B, C and D with respect to the kernel's parameters, each with a leading axis of n_p."""
        symbolic = _symbolic(self.plant)
        direct = symbolic.by_parameter(*self._arguments)
        # The total derivative: the matrices depend on a parameter directly and through the rest point that it shifts.
        moved = symbolic.by_state(*self._arguments)
        out = []
        for own, through in zip(direct, moved, strict=True):
            along = np.tensordot(self.x_by_parameter.T, np.array(through, dtype=np.float64), axes=1)
            out.append(np.array(own, dtype=np.float64) + along)
        return tuple(out)  # type: ignore[return-value]

    def response(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return C (i w - A)^-1 B + D, (f, n_y, m), at frequencies above 0."""
        A, B, C, D = self.matrices
        resolved = np.linalg.solve(1j * _angular(frequency_hz)[:, None, None] * np.eye(len(A)) - A, B + 0j)
        return np.asarray(C @ resolved + D, dtype=np.complex128)

    def response_by_parameter(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return the derivative of the response with respect to the kernel's parameters, (n_p, f, n_y, m)."""
        A, B, C, _ = self.matrices
        dA, dB, dC, dD = self.by_parameter
        # d(M^-1) = M^-1 dA M^-1 with M = i w - A: two solves serve all parameters.
        M = 1j * _angular(frequency_hz)[:, None, None] * np.eye(len(A)) - A
        right = np.linalg.solve(M, B + 0j)
        left = np.linalg.solve(np.swapaxes(M, 1, 2), C.T + 0j).swapaxes(1, 2)
        return np.array([c @ right + left @ (a @ right + b) + d for a, b, c, d in zip(dA, dB, dC, dD, strict=True)])

    @property
    def outputs(self) -> FloatArray:
        """Outputs at the rest point, (n_y,)."""
        quantity = equations_of(self.plant).outputs
        return quantity(*self._arguments)

    def evaluate(self, expr: sp.Expr) -> float:
        """Return the value of an expression in the plant's symbols at the rest point."""
        at = dict(zip((*self.plant.states, *self.plant.filter.states), self.x.tolist(), strict=True))
        at |= dict(zip(self.plant.inputs, self.inputs.tolist(), strict=True)) | dict(self.holding)
        at |= dict(zip(self.plant.parameters, self.p.tolist(), strict=True))
        return float(self.plant.expand(expr).subs(at))

    def margins(self) -> dict[str, float]:
        """Return the distance of each holding friction from its release, by the switch's name, in its torque's unit."""
        return {
            switch.name: min(self.evaluate(guard.margin) for guard in switch.guards[switch.otherwise])
            for switch in self.plant.switches
            if _rubs(switch) and switch.modes[switch.otherwise].items() <= self.holding.items()
        }

    @property
    def _arguments(self) -> tuple[Sequence[float], ...]:
        modes = [self.holding[symbol] for symbol in _mode_symbols(self.plant)]
        return (self.x.tolist(), self.inputs.tolist(), modes, self.p.tolist())


def linearise(plant: Plant, p: FloatArray, inputs: FloatArray, theta_0: float, holding: Holding) -> Linearised:
    """Linearise a plant at rest.

    Parameters
    ----------
    plant : Plant
    p : (n_p,)
        The kernel's parameters, SI.
    inputs : (m,)
        Held values, in the plant's order.
    theta_0 : float
        Commanded electrical angle, rad; the equilibrium nearest to it is used.
    holding : mapping of Symbol to float
        One of `holdings`.

    Raises
    ------
    FitError
        There is no equilibrium within reach.
    """
    x, x_p = equilibrium(plant, p, inputs, theta_0)
    # The filter is linear, so the matrices do not depend on its states: zeros serve.
    behind = len(plant.filter.states)  # a linear filter: where it stands moves no matrix
    x, x_p = np.concatenate([x, np.zeros(behind)]), np.vstack([x_p, np.zeros((behind, p.size))])
    return Linearised(plant, p, x, x_p, inputs, holding)


def held_inputs(plant: Plant, command: Command | None = None) -> FloatArray:
    """Return the inputs, (m,), that a command holds before its first step; inputs of a base or a channel are zero."""
    steps = sum(symbol.name in ("e_A", "e_B") for symbol in plant.inputs)
    driver = command or Command(stepping="full", microsteps=1, rate=RateProfile.constant(0.0))
    return np.concatenate([driver.excitation(0.0).initial[:steps], np.zeros(len(plant.inputs) - steps)])


def holdings(plant: Plant) -> tuple[Holding, ...]:
    """Return the combinations of switch modes at rest: each switch in its resting mode, or removed."""
    each = [
        [dict(switch.modes[switch.otherwise]), {**switch.modes[switch.otherwise], **switch.ideal}]
        for switch in plant.switches
    ]
    joined = [{k: v for part in chosen for k, v in part.items()} for chosen in itertools.product(*each)]
    # A switch whose resting mode is its ideal one gives the same combination twice.
    return tuple(h for k, h in enumerate(joined) if h not in joined[:k])


def rotor_held(plant: Plant) -> Holding:
    """Return the switch modes where friction holds the rotor and every other switch is removed."""
    rate = plant.offered.get("rotor_rate")
    # Ideal values remove a switch; a switch that resets the rotor's rate is the one that holds it.
    out: dict[sp.Symbol, float] = {}
    for switch in plant.switches:
        out |= {**switch.modes[switch.otherwise], **switch.ideal}
        if any(rate in guard.resets for guards in switch.guards.values() for guard in guards):
            out |= switch.modes[switch.otherwise]
    return out


def named_holdings(plant: Plant) -> dict[str, Holding]:
    """Return the distinct holdings by name.

    ``"stuck"``: friction holds the rotor and nothing else. ``"locked"``: it also holds the load, if the load has
    friction of its own. ``"free"``: friction is removed. If friction never holds, as with bristles, ``"holding"``
    alone. Other switches, such as a backlash, are removed in all of them.
    """
    free = holdings(plant)[-1]
    locked = dict(free)
    for switch in filter(_rubs, plant.switches):
        locked |= switch.modes[switch.otherwise]
    stuck = rotor_held(plant)
    if locked == free:
        return {"holding": free}
    return {"stuck": stuck, **({"locked": locked} if locked != stuck else {}), "free": free}


def _rubs(switch: Switch) -> bool:
    """Return whether a switch holds a body at rest; an open coil, which is removed as it rests, holds none."""
    resting = switch.modes[switch.otherwise]
    holds = any(guard.resets for guards in switch.guards.values() for guard in guards)
    return holds and {**resting, **switch.ideal} != dict(resting)


@dataclass(frozen=True)
class _Symbolic:
    """Compiled matrices of (states, inputs, modes, parameters), with their parameter and state derivatives."""

    arguments: tuple[tuple[sp.Symbol, ...], ...]
    expressions: tuple[sp.Matrix, ...]

    @cached_property
    def matrices(self) -> Compiled:
        return self._compile([matrix.tolist() for matrix in self.expressions])

    @cached_property
    def by_parameter(self) -> Compiled:
        return self._derivatives(self.arguments[3])

    @cached_property
    def by_state(self) -> Compiled:
        return self._derivatives(self.arguments[0])

    def _derivatives(self, symbols: Sequence[sp.Symbol]) -> Compiled:
        return self._compile([[matrix.diff(s).tolist() for s in symbols] for matrix in self.expressions])

    def _compile(self, expressions: object) -> Compiled:
        # The arguments are single numbers, for which the math module is faster than NumPy.
        function: Compiled = sp.lambdify(self.arguments, expressions, modules="math", cse=True)
        return function


@lru_cache(maxsize=32)
def _symbolic(plant: Plant) -> _Symbolic:
    states = (*plant.states, *plant.filter.states)
    rates = sp.Matrix([*map(plant.expand, map(sp.sympify, plant.rates)), *_flow(plant)])
    outputs = sp.Matrix([plant.expand(sp.sympify(e)) for e in plant.outputs.values()])
    arguments = (states, plant.inputs, _mode_symbols(plant), plant.parameters)
    matrices = (
        rates.jacobian(states),
        _jacobian(rates, plant.inputs),
        outputs.jacobian(states),
        _jacobian(outputs, plant.inputs),
    )
    return _Symbolic(arguments, matrices)


def _jacobian(of: sp.Matrix, by: Sequence[sp.Symbol]) -> sp.Matrix:
    return of.jacobian(by) if by else sp.zeros(of.rows, 0)


def _flow(plant: Plant) -> list[sp.Expr]:
    system = plant.filter
    flow = system.A * sp.Matrix(system.states) + system.B * sp.Matrix(system.inputs)
    return [plant.expand(e) for e in flow]


def _mode_symbols(plant: Plant) -> tuple[sp.Symbol, ...]:
    return tuple(m for s in plant.switches for m in next(iter(s.modes.values())))


def _angular(frequency_hz: FloatArray) -> FloatArray:
    return np.asarray(2.0 * np.pi * np.asarray(frequency_hz), dtype=np.float64)
