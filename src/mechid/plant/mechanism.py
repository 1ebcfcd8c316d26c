"""Mechanisms: a plant with values, bounds, priors and status of its parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
import sympy as sp

from mechid.arrays import FloatArray
from mechid.command import Command
from mechid.command.pulse import Pulse
from mechid.parameter import Declaration, Parameter, Status
from mechid.plant.phases import FULL_STEPS
from mechid.plant.plant import Plant
from mechid.plant.pulses import HOLD, ON
from mechid.plant.start import HOLDING_TORQUE
from mechid.plant.stepper import HOLDING

CLOCK_LINES = 3
"""Multiples of a clock's frequency that are looked for in records."""


@dataclass(frozen=True)
class Harmonic:
    """A harmonic over the rotor's angle: of the detent, of the torque constant, or of the gear's kinematic error.

    Attributes
    ----------
    name : str
        Name of its table, e.g. ``"stepper.detent.0"``.
    orders : float
        Periods per electrical period.
    period_deg : float
        Rotor angle of one period.
    of_phase : bool
        Whether it belongs to the motor's phases, and stays in place if the zero of the rotor angle is moved.
    of_rotor : bool
        Whether it has at least one period per turn of the rotor; the weight of a load on a gear has not.
    """

    name: str
    orders: float
    period_deg: float
    of_phase: bool
    of_rotor: bool

    @property
    def words(self) -> str:
        """Plain name, e.g. ``"detent"``."""
        return [part for part in self.name.split(".") if not part.isdigit()][-1].replace("_", " ")


@dataclass(frozen=True)
class NamedLine:
    """A disturbance that the file states by name, such as that of a tooth mesh, whether or not an equation has it.

    Attributes
    ----------
    name : str
        For example ``"mesh 1"``.
    words : str
    per_turn : float
        Periods per turn of the rotor; NaN of a clock.
    order : float or None
        Periods per full step of the motor; None without a stepper, and of a clock.
    frequency_hz : float or None
        Frequency of a clock; None of all others.
    """

    name: str
    words: str
    per_turn: float
    order: float | None
    frequency_hz: float | None = None

    def lines_hz(self, rate: float | None, sample_rate_hz: float) -> tuple[float, ...]:
        """Return where a record shows it: at a step rate in full steps/s, or folded back by the sampling.

        Of a clock these are its first `CLOCK_LINES` multiples, of which a recorder without a filter shows aliases.
        """
        if self.frequency_hz is not None:
            multiples = [k * self.frequency_hz for k in range(1, CLOCK_LINES + 1)]
            return tuple(abs(f - round(f / sample_rate_hz) * sample_rate_hz) for f in multiples)
        return (self.order * abs(rate),) if rate and self.order else ()


@dataclass(frozen=True, repr=False)
class Mechanism:
    """A plant and its parameters, in the file's coordinates and units.

    Parameters
    ----------
    plant : Plant
    parameters : mapping of str to Parameter
        By dotted name, one for each of the plant's declarations.
    options : mapping of str to str
        Choices that are not numbers: assembly, housing form.
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
        """Parameters that the fit may change."""
        return tuple(q for q in self.parameters.values() if q.is_free)

    def value(self, name: str) -> float:
        """Return the value of a parameter; for a tied one, that of its master."""
        parameter = self.parameters[name]
        return self.value(parameter.tied_to) if parameter.tied_to else parameter.value

    @cached_property
    def electrical_periods(self) -> float | None:
        """Electrical periods per turn of the rotor; None if no start angle turns it, as without a stepper."""
        rotor = self.plant.offered.get("rotor_angle")
        if rotor not in self.plant.start_angle_slopes:
            return None
        by_value = dict(zip(self.plant.parameters, self.kernel_values().tolist(), strict=True))
        # An electrical radian of the start angle turns the rotor by its slope; a turn takes the reciprocal.
        return abs(1.0 / float(self.plant.start_angle_slopes[rotor].subs(by_value)))

    @property
    def phases(self) -> int:
        """Number of phases of the stepper, 2 where there is none."""
        return self.plant.layout.phases if self.plant.layout else 2

    @property
    def full_steps(self) -> int:
        """Full steps of the motor in an electrical period."""
        return FULL_STEPS[self.phases]

    @cached_property
    def pulse(self) -> Pulse | None:
        """Pulses of the stepper's driver, None if it holds its phases from step to step."""
        if ON not in self.parameters:
            return None
        return Pulse(self.value(ON), self.value(HOLD) if HOLD in self.parameters else 0.0)

    def command_for(self, command: Command) -> Command:
        """Return a command as the mechanism's motor and driver follow it.

        Raises
        ------
        UsageError
            The motor cannot have it, or a step is shorter than a pulse.
        """
        return command.for_motor(self.phases, self.pulse)

    def per_quarter(self, per_step: float) -> float:
        """Convert a count per full step of the motor to one per quarter of an electrical period, as blocks count."""
        return per_step * self.full_steps / FULL_STEPS[2]

    def scale(self, words: str) -> float | None:
        """Return a quantity of the data sheet, as ``"holding torque"`` in N m; None if no block has it."""
        for block in self.plant.blocks:
            if words in block.scales:
                return float(block.scales[words].subs(self.by_symbol))
        return None

    def size(self, declaration: Declaration) -> float | None:
        """Return the typical magnitude of a start value of a record; None if this mechanism does not determine it."""
        if declaration.typical is None:
            return None
        holding = next((b.scales[HOLDING] for b in self.plant.blocks if HOLDING in b.scales), HOLDING_TORQUE)
        # A data sheet's holding torque takes the place of the placeholder in the typical magnitude.
        size = sp.sympify(declaration.typical[0], locals=self._locals).subs(HOLDING_TORQUE, holding)
        return float(size.subs(self.by_symbol)) if size.free_symbols <= self.by_symbol.keys() else None

    @cached_property
    def _locals(self) -> dict[str, sp.Symbol]:
        """The file's symbols by name; without them SymPy would parse some names as its own."""
        return {s.name: s for s in (*self.by_symbol, HOLDING_TORQUE)}

    @cached_property
    def by_symbol(self) -> dict[sp.Symbol, float]:
        """Values by the file's symbols."""
        return {sp.Symbol(d.symbol): self.value(name) for name, d in self.plant.declarations.items()}

    @cached_property
    def harmonics(self) -> tuple[Harmonic, ...]:
        """Harmonics over the rotor's angle; none without a start angle that turns the rotor."""
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

    @cached_property
    def named_lines(self) -> tuple[NamedLine, ...]:
        """Lines that the blocks name, in their order; of those of one order the first, with the words of all."""
        found: dict[str, NamedLine] = {}
        for one in (order for block in self.plant.blocks for order in block.named_orders):
            cycles = float(one.cycles.subs(self.by_symbol))
            if one.per_second and cycles <= 0.0:
                continue
            words = one.words.format(**{k: float(e.subs(self.by_symbol)) for k, e in one.values.items()})
            if one.per_second:
                found[one.name] = NamedLine(one.name, words, math.nan, None, cycles)
                continue
            key, steps = f"{cycles:.9g}", self.electrical_periods
            order = cycles / (self.full_steps * steps) if steps else None
            there = found.get(key)
            words = f"{there.words}, and {words}" if there else words
            found[key] = NamedLine(there.name if there else one.name, words, cycles, order)
        return tuple(found.values())

    def kernel_values(self, changed: Mapping[str, float] | None = None) -> FloatArray:
        """Return the kernel's parameters, (n,), in the plant's order and SI units.

        `changed` holds values of the file that replace the mechanism's own; tied parameters follow.
        """
        masters, values = self._masters
        if changed:
            values = {**values, **changed}
        return np.array(_coordinates(self.plant)(*[values[name] for name in masters]), dtype=np.float64)

    @cached_property
    def _masters(self) -> tuple[tuple[str, ...], dict[str, float]]:
        """Names of the parameters that supply the values, in the order of the declarations, and all values."""
        names = tuple(self.parameters[name].tied_to or name for name in self.plant.declarations)
        return names, {name: q.value for name, q in self.parameters.items()}

    def kernel_jacobian(self) -> dict[str, FloatArray]:
        """Return the derivatives of the kernel's parameters with respect to each untied value, {name: (n,)}."""
        names = tuple(self.plant.declarations)
        entries, slopes_at = _compile_map_slopes(*self.plant.file_map)
        matrix = np.zeros((len(self.plant.parameters), len(names)))
        matrix[entries] = slopes_at(*map(self.value, names))
        columns = {name: matrix[:, j].copy() for j, name in enumerate(names)}
        for q in self.parameters.values():
            # A tied parameter adds its derivative to that of its master.
            if q.tied_to:
                columns[q.tied_to] += columns.pop(q.name)
        return columns

    def contradictions(self) -> Iterator[tuple[str, str]]:
        """Yield each parameter whose value contradicts another's, with the contradiction and the remedy."""
        declared, value = self.plant.declarations, self.value
        for name, other in self.plant.related_parameters("above").items():
            if value(name) < value(other):
                never = f"{declared[name].meaning} is never below {declared[other].meaning}"
                least = f"{value(other):.9g}"
                yield name, f"{value(name):.9g} is below {other} = {least}; {never}: start at {least} or above"
        for name, other in self.plant.related_parameters("beyond").items():
            if value(name) <= value(other):
                yield name, f"{value(name):.9g} is not above {other} = {value(other):.9g}; exchange them"
        parts = self.plant.related_parameters("part_of")
        for whole in dict.fromkeys(parts.values()):
            together = sum(value(name) for name, other in parts.items() if other == whole)
            if value(whole) <= together:
                off = f"{value(whole):.9g} is not above the modes' {together:.9g}"
                yield whole, f"{off}; it is the inertia of the whole load, its modes included"
        for one in (agreement for block in self.plant.blocks for agreement in block.agreements):
            given, wanted = (float(e.subs(self.by_symbol)) for e in (one.value, one.wanted))
            if abs(given - wanted) > one.within * wanted:
                yield one.name, one.words.format(value=given, wanted=wanted, missing=wanted / given)
        for name, d in declared.items():
            if d.even and value(name) % 2.0:
                yield name, f"found {value(name):.9g}; {d.key} come in pairs, write an even whole number"

    def with_values(self, values: Mapping[str, float]) -> Mechanism:
        """Return the mechanism with some values replaced."""
        moved = {name: self.parameters[name].at_value(v) for name, v in values.items()}
        return replace(self, parameters={**self.parameters, **moved})

    def with_parameters(self, changed: Mapping[str, Parameter]) -> Mechanism:
        """Return the mechanism with some parameters replaced."""
        return replace(self, parameters={**self.parameters, **changed})

    def with_free(self, names: tuple[str, ...]) -> Mechanism:
        """Return the mechanism with `names` as its only free parameters; other free ones become known."""
        held = {q.name: replace(q, status=Status.KNOWN) for q in self.free if q.name not in names}
        return self.with_parameters(held)


Expressions = tuple[sp.Expr, ...]


def _coordinates(plant: Plant) -> Callable[..., list[float]]:
    """Return the map from the file's values, in the order of the declarations, to the kernel's parameters."""
    return _compile_map(*plant.file_map)


@lru_cache(maxsize=64)
def _compile_map(symbols: tuple[sp.Symbol, ...], expressions: Expressions) -> Callable[..., list[float]]:
    compiled: Callable[..., list[float]] = sp.lambdify(symbols, list(expressions), modules="math")
    return compiled


@lru_cache(maxsize=64)
def _compile_map_slopes(
    symbols: tuple[sp.Symbol, ...], expressions: Expressions
) -> tuple[tuple[list[int], list[int]], Callable[..., list[float]]]:
    """Return rows and columns of the entries of the map's Jacobian that are not zero, and the function of these."""
    # Nearly all of the hundreds of entries are zero; SymPy would differentiate and print each.
    entries = [(i, j) for i, e in enumerate(expressions) for j, f in enumerate(symbols) if f in e.free_symbols]
    slopes = [sp.diff(expressions[i], symbols[j]) for i, j in entries]
    compiled: Callable[..., list[float]] = sp.lambdify(symbols, slopes, modules="math")
    return ([i for i, _ in entries], [j for _, j in entries]), compiled
