"""A mechanism: a plant with what is known and believed of each of its parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
import sympy as sp

from mechid.arrays import FloatArray
from mechid.parameter import Declaration, Parameter, Status
from mechid.plant.plant import Plant
from mechid.plant.start import HOLDING_TORQUE
from mechid.plant.stepper import HOLDING


@dataclass(frozen=True)
class Harmonic:
    """A harmonic of the rotor's angle: a detent, one of the torque constant, of the gear's kinematic error.

    Attributes
    ----------
    name : str
        Of its table, e.g. ``"stepper.detent.0"``.
    orders : float
        Its periods in an electrical period.
    period_deg : float
        Angle of the rotor in which it has one period.
    of_phase : bool
        Whether it belongs to the motor's phases, and stays when the rotor's zero is put elsewhere.
    of_rotor : bool
        Whether it has a period in each turn of the rotor; the weight of a load on a gear has not.
    """

    name: str
    orders: float
    period_deg: float
    of_phase: bool
    of_rotor: bool

    @property
    def words(self) -> str:
        """What it is called, e.g. ``"detent"``."""
        return [part for part in self.name.split(".") if not part.isdigit()][-1].replace("_", " ")


@dataclass(frozen=True, repr=False)
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

    def __repr__(self) -> str:
        return f"<Mechanism {self.plant.name}: {len(self.parameters)} parameters, {len(self.free)} free>"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{q.name}</td><td>{self.value(q.name):.9g}</td><td>{q.declaration.unit}</td><td>{q.status}</td></tr>"
            for q in self.parameters.values()
        )
        head = "<tr><th>parameter</th><th>value</th><th>unit</th><th>status</th></tr>"
        return f"<table><thead>{head}</thead><tbody>{rows}</tbody></table>"

    @cached_property
    def free(self) -> tuple[Parameter, ...]:
        """Parameters the fit may move."""
        return tuple(q for q in self.parameters.values() if q.is_free)

    def value(self, name: str) -> float:
        """Return the value of a parameter, that of its master where it is tied."""
        parameter = self.parameters[name]
        return self.value(parameter.tied_to) if parameter.tied_to else parameter.value

    @cached_property
    def electrical_periods(self) -> float | None:
        """Electrical periods in a turn of the rotor; None where no start angle turns anything, as without a stepper."""
        rotor = self.plant.offered.get("rotor_angle")
        if rotor not in self.plant.turned:
            return None
        by_value = dict(zip(self.plant.parameters, self.kernel_values().tolist(), strict=True))
        return abs(1.0 / float(self.plant.turned[rotor].subs(by_value)))

    def scale(self, words: str) -> float | None:
        """Return what a data sheet names, as ``"holding torque"`` in N m; None where no block has it."""
        for block in self.plant.blocks:
            if words in block.scales:
                return float(block.scales[words].subs(self.by_symbol))
        return None

    def size(self, declaration: Declaration) -> float | None:
        """Return how large mostly is what is declared of a record's start; None where this mechanism does not tell."""
        if declaration.typical is None:
            return None
        holding = next((b.scales[HOLDING] for b in self.plant.blocks if HOLDING in b.scales), HOLDING_TORQUE)
        size = sp.sympify(declaration.typical[0], locals=self._locals).subs(HOLDING_TORQUE, holding)
        return float(size.subs(self.by_symbol)) if size.free_symbols <= self.by_symbol.keys() else None

    @cached_property
    def _locals(self) -> dict[str, sp.Symbol]:
        """Return the file's symbols by name: without them SymPy takes some names for its own."""
        return {s.name: s for s in (*self.by_symbol, HOLDING_TORQUE)}

    @cached_property
    def by_symbol(self) -> dict[sp.Symbol, float]:
        """Values by the file's symbols."""
        return {sp.Symbol(d.symbol): self.value(name) for name, d in self.plant.declarations.items()}

    @cached_property
    def harmonics(self) -> tuple[Harmonic, ...]:
        """The plant's harmonics of the rotor's angle; none where no start angle turns anything."""
        if self.electrical_periods is None:
            return ()
        cycles = [(pair, float(pair.cycles.subs(self.by_symbol))) for pair in self.plant.polar_pairs]
        return tuple(
            Harmonic(
                name=pair.amplitude.rpartition(".")[0],
                orders=turns / self.electrical_periods,
                period_deg=360.0 / turns,
                of_phase=pair.of_phase,
                of_rotor=abs(turns) >= 1.0,
            )
            for pair, turns in cycles
        )

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

    def contradictions(self) -> Iterator[tuple[str, str]]:
        """Yield each parameter whose value cannot be beside those of others, with what is wrong and the remedy."""
        declared, value = self.plant.declarations, self.value
        for name, other in self.plant.related("above").items():
            if value(name) < value(other):
                never = f"{declared[name].meaning} is never below {declared[other].meaning}"
                least = f"{value(other):.9g}"
                yield name, f"{value(name):.9g} is below {other} = {least}; {never}: start at {least} or above"
        for name, other in self.plant.related("beyond").items():
            if value(name) <= value(other):
                yield name, f"{value(name):.9g} is not above {other} = {value(other):.9g}; exchange them"
        parts = self.plant.related("part_of")
        for whole in dict.fromkeys(parts.values()):
            together = sum(value(name) for name, other in parts.items() if other == whole)
            if value(whole) <= together:
                off = f"{value(whole):.9g} is not above the modes' {together:.9g}"
                yield whole, f"{off}; it is the inertia of the whole load, its modes included"
        for name, d in declared.items():
            if d.even and value(name) % 2.0:
                yield name, f"found {value(name):.9g}; {d.key} come in pairs, write an even whole number"

    def with_values(self, values: Mapping[str, float]) -> Mechanism:
        """Return the same mechanism with some parameters at other values."""
        moved = {name: self.parameters[name].at_value(v) for name, v in values.items()}
        return replace(self, parameters={**self.parameters, **moved})

    def with_parameters(self, changed: Mapping[str, Parameter]) -> Mechanism:
        """Return the same mechanism with some parameters replaced."""
        return replace(self, parameters={**self.parameters, **changed})

    def with_free(self, names: tuple[str, ...]) -> Mechanism:
        """Return the same mechanism in which of its free parameters only `names` stay free."""
        held = {q.name: replace(q, status=Status.KNOWN) for q in self.free if q.name not in names}
        return self.with_parameters(held)


Expressions = tuple[sp.Expr, ...]


def _coordinates(plant: Plant) -> Callable[..., list[float]]:
    """Return the map from the file's values, in the order of the declarations, to the kernel's."""
    return _mapped(*plant.file_map)


def _coordinate_slopes(plant: Plant) -> Callable[..., list[list[float]]]:
    """Return the derivative of that map, (kernel parameters, declarations)."""
    return _slopes(*plant.file_map)


@lru_cache(maxsize=64)
def _mapped(symbols: tuple[sp.Symbol, ...], expressions: Expressions) -> Callable[..., list[float]]:
    compiled: Callable[..., list[float]] = sp.lambdify(symbols, list(expressions), modules="math")
    return compiled


@lru_cache(maxsize=64)
def _slopes(symbols: tuple[sp.Symbol, ...], expressions: Expressions) -> Callable[..., list[list[float]]]:
    rows = [[sp.diff(e, f) for f in symbols] for e in expressions]
    compiled: Callable[..., list[list[float]]] = sp.lambdify(symbols, rows, modules="math")
    return compiled
