"""Equations of a plant as plain Python functions, by SymPy's lambdify, for the slow twin."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import sympy as sp

from mechid.arrays import FloatArray
from mechid.plant.plant import START_ANGLE, Plant

Arguments = tuple[tuple[sp.Symbol, ...], ...]
"""Four groups of symbols: states, inputs, mode symbols, parameters."""


@dataclass(frozen=True)
class Quantity:
    """A vector of expressions in (states, inputs, modes, parameters), with its partial derivatives."""

    arguments: Arguments
    expressions: tuple[sp.Expr, ...]

    def __call__(self, *at: Sequence[float]) -> FloatArray:
        """Return the values, (k,), at one point."""
        return np.array(self._scalars(*at), dtype=np.float64)

    def along(self, states: FloatArray, *rest: Sequence[float]) -> FloatArray:
        """Return the values, (k, n), at states (n_states, n)."""
        # An expression without states evaluates to a scalar.
        return np.array([np.broadcast_to(v, states.shape[1:]) for v in self._arrays(states, *rest)])

    def by_state(self, *at: Sequence[float]) -> FloatArray:
        """Return the derivatives with respect to the states, (k, n_states)."""
        return np.array(self._by_state(*at), dtype=np.float64).reshape(len(self.expressions), -1)

    def by_parameter(self, *at: Sequence[float]) -> FloatArray:
        """Return the derivatives with respect to the parameters, (k, n_p)."""
        return np.array(self._by_parameter(*at), dtype=np.float64).reshape(len(self.expressions), -1)

    @cached_property
    def _scalars(self) -> Callable[..., list[float]]:
        function: Callable[..., list[float]] = self._lambdify(self.expressions, "math")
        return function

    @cached_property
    def _arrays(self) -> Callable[..., list[FloatArray]]:
        function: Callable[..., list[FloatArray]] = self._lambdify(self.expressions, "numpy")
        return function

    @cached_property
    def _by_state(self) -> Callable[..., list[float]]:
        return self._gradient(self.arguments[0])

    @cached_property
    def _by_parameter(self) -> Callable[..., list[float]]:
        return self._gradient(self.arguments[-1])

    def _gradient(self, symbols: Sequence[sp.Symbol]) -> Callable[..., list[float]]:
        derivatives = [sp.diff(e, s) for e in self.expressions for s in symbols]
        function: Callable[..., list[float]] = self._lambdify(derivatives, "math")
        return function

    def _lambdify(self, expressions: Sequence[sp.Expr], modules: str) -> Any:
        return sp.lambdify(self.arguments, list(expressions), modules=modules, cse=True)


@dataclass(frozen=True)
class Equations:
    """Functions of one plant; its states are followed by those of its filter."""

    plant: Plant

    @cached_property
    def states(self) -> tuple[sp.Symbol, ...]:
        """States of the plant, then of the filter."""
        return (*self.plant.states, *self.plant.filter.states)

    @cached_property
    def rates(self) -> Quantity:
        """Time derivatives of `states`."""
        linear = self.plant.filter
        flow = linear.A * sp.Matrix(linear.states) + linear.B * sp.Matrix(linear.inputs)
        return self._quantity((*self.plant.rates, *flow))

    @cached_property
    def outputs(self) -> Quantity:
        """Measured quantities."""
        return self._quantity(tuple(self.plant.outputs.values()))

    @cached_property
    def initial(self) -> Quantity:
        """States at the start of a record, as a function of the start angle in place of the states."""
        start = (*self.plant.initial, *(0 for _ in self.plant.filter.states))
        return Quantity(((START_ANGLE,), *self._others), tuple(map(sp.sympify, start)))

    @cached_property
    def margins(self) -> tuple[tuple[Quantity, ...], ...]:
        """Margins of the guards of each mode of each switch."""
        return tuple(
            tuple(self._quantity(tuple(g.margin for g in s.guards.get(mode, ()))) for mode in s.modes)
            for s in self.plant.switches
        )

    @cached_property
    def entry(self) -> tuple[Quantity, ...]:
        """Entry rules of each switch."""
        return tuple(self._quantity(tuple(e for e, _ in s.entry)) for s in self.plant.switches)

    def mode_symbols(self, modes: Sequence[int]) -> list[float]:
        """Return the values of all mode symbols while the switches are in `modes`."""
        chosen = [list(s.modes.values())[k] for s, k in zip(self.plant.switches, modes, strict=True)]
        return [float(v) for values in chosen for v in values.values()]

    @cached_property
    def _others(self) -> Arguments:
        modes = tuple(m for s in self.plant.switches for m in next(iter(s.modes.values())))
        return (self.plant.inputs, modes, self.plant.parameters)

    def _quantity(self, expressions: Sequence[sp.Expr]) -> Quantity:
        expanded = tuple(self.plant.expand(sp.sympify(e)) for e in expressions)
        return Quantity((self.states, *self._others), expanded)


@lru_cache(maxsize=32)
def equations_of(plant: Plant) -> Equations:
    """Return the functions of a plant, from a cache."""
    return Equations(plant)
