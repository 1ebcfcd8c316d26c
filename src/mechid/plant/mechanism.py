"""A mechanism: a plant with what is known and believed of each of its parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from mechid.parameter import Parameter, Status
from mechid.plant.plant import Plant

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Mechanism:
    """A plant and its parameters, in the file's coordinates and units.

    Parameters
    ----------
    plant : Plant
    parameters : mapping of str to Parameter
        By dotted name, one for each of the plant's declarations.
    options : mapping of str to str
        What is not a number: assembly, housing form.
    """

    plant: Plant
    parameters: Mapping[str, Parameter]
    options: Mapping[str, str]

    @cached_property
    def free(self) -> tuple[Parameter, ...]:
        """Parameters the fit may move."""
        return tuple(q for q in self.parameters.values() if q.is_free)

    def value(self, name: str) -> float:
        """Return the value of a parameter, that of its master where it is tied."""
        parameter = self.parameters[name]
        return self.value(parameter.tied_to) if parameter.tied_to else parameter.value

    def kernel_values(self, changed: Mapping[str, float] | None = None) -> FloatArray:
        """Return the kernel's parameters, (n,), in the plant's order and SI units.

        `changed` are values of the file that differ from the mechanism's own; ties follow them.
        """
        masters, values = self._masters
        if changed:
            values = {**values, **changed}
        return np.array(_coordinates(self.plant)(*[values[name] for name in masters]), dtype=np.float64)

    @cached_property
    def _masters(self) -> tuple[tuple[str, ...], dict[str, float]]:
        """Return, in the order of the declarations, whose value each parameter takes; and all values."""
        names = tuple(self.parameters[name].tied_to or name for name in self.plant.declarations)
        return names, {name: q.value for name, q in self.parameters.items()}

    def kernel_jacobian(self) -> dict[str, FloatArray]:
        """Return the derivative of the kernel's parameters to each untied value of the file, {name: (n,)}."""
        names = tuple(self.plant.declarations)
        matrix = np.asarray(_coordinate_slopes(self.plant)(*map(self.value, names)), dtype=np.float64)
        columns = {name: matrix[:, j].copy() for j, name in enumerate(names)}
        for q in self.parameters.values():
            if q.tied_to:
                columns[q.tied_to] += columns.pop(q.name)
        return columns

    def with_values(self, values: Mapping[str, float]) -> Mechanism:
        """Return the same mechanism with some parameters at other values."""
        moved = {name: self.parameters[name].moved_to(v) for name, v in values.items()}
        return replace(self, parameters={**self.parameters, **moved})

    def with_parameters(self, changed: Mapping[str, Parameter]) -> Mechanism:
        """Return the same mechanism with some parameters replaced."""
        return replace(self, parameters={**self.parameters, **changed})

    def with_free(self, names: tuple[str, ...]) -> Mechanism:
        """Return the same mechanism in which of its free parameters only `names` stay free."""
        held = {q.name: replace(q, status=Status.KNOWN) for q in self.free if q.name not in names}
        return self.with_parameters(held)


@lru_cache(maxsize=32)
def _coordinates(plant: Plant) -> Callable[..., list[float]]:
    """Compile the map from the file's values, in the order of the declarations, to the kernel's."""
    symbols = [sp.Symbol(d.symbol) for d in plant.declarations.values()]
    expressions = [plant.coordinates[s] for s in plant.parameters]
    compiled: Callable[..., list[float]] = sp.lambdify(symbols, expressions, modules="math")
    return compiled


@lru_cache(maxsize=32)
def _coordinate_slopes(plant: Plant) -> Callable[..., list[list[float]]]:
    """Compile the derivative of that map, (kernel parameters, declarations)."""
    symbols = [sp.Symbol(d.symbol) for d in plant.declarations.values()]
    rows = [[sp.diff(plant.coordinates[s], f) for f in symbols] for s in plant.parameters]
    compiled: Callable[..., list[list[float]]] = sp.lambdify(symbols, rows, modules="math")
    return compiled
