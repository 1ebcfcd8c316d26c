"""Assembly of blocks and wiring into a plant: states, ordered terms, rates, switches, filter, outputs."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import sympy as sp

from mechid.parameter import Declaration, Role
from mechid.plant.block import Block, LinearSystem, PolarPair, Switch
from mechid.plant.filter_chain import NO_FILTER, combine_filters
from mechid.plant.layout import Layout
from mechid.plant.tables import MOTOR_OF_RECORD, OF_RECORD
from mechid.plant.terms import sort_terms, start_states, structure_text
from mechid.plant.wiring import Links

START_ANGLE = sp.Symbol("theta_0")


@dataclass(frozen=True, kw_only=True, eq=False)
class Plant:
    """A wired plant in symbols; the source of the kernel generator, the slow twin and the documentation.

    Attributes
    ----------
    name : str
    blocks : tuple of Block
    states : tuple of Symbol, (n,)
        States of the nonlinear part.
    terms : tuple of (Symbol, Expr)
        Ordered so that each contains only states, parameters, inputs, mode symbols and earlier terms.
    rates : tuple of Expr, (n,)
    initial : tuple of Expr, (n,)
        At rest where the command begins: functions of parameters, inputs and `START_ANGLE`.
    start_expressions : mapping of Symbol to Expr
        Initial states of plant and filter for a record with start values of its own: functions of the symbols of
        `starts` too.
    inputs : tuple of Symbol
        Excitation, e.g. the normalised phase voltages.
    switches : tuple of Switch
    filter : LinearSystem
        Closed-form linear part behind the plant; may be empty.
    outputs : mapping of quantity to Expr
        Functions of states, terms, filter states and parameters.
    parameters : tuple of Symbol
        The kernel's parameters, in order.
    offered : mapping of quantity to Expr
        All quantities that `with_outputs` accepts.
    behind : LinearSystem
        The filters of all blocks, whether or not an output depends on them.
    layout : Layout or None
        The layout that it was assembled from; None for a plant that is no assembly of the library.
    """

    name: str
    blocks: tuple[Block, ...]
    states: tuple[sp.Symbol, ...]
    terms: tuple[tuple[sp.Symbol, sp.Expr], ...]
    rates: tuple[sp.Expr, ...]
    initial: tuple[sp.Expr, ...]
    inputs: tuple[sp.Symbol, ...]
    switches: tuple[Switch, ...]
    filter: LinearSystem
    outputs: Mapping[str, sp.Expr]
    parameters: tuple[sp.Symbol, ...]
    offered: Mapping[str, sp.Expr]
    start_expressions: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    behind: LinearSystem = NO_FILTER
    layout: Layout | None = None

    def with_outputs(self, quantities: Sequence[str]) -> Plant:
        """Return the plant with other outputs, taken from `offered`; a filter that none of them needs is dropped."""
        chosen = tuple(quantities)
        if chosen not in self._with_outputs:
            self._with_outputs[chosen] = self._make_with_outputs(chosen)
        return self._with_outputs[chosen]

    @cached_property
    def _with_outputs(self) -> dict[tuple[str, ...], Plant]:
        """Plants that `with_outputs` has returned: the symbols of one, and its digest, take tens of milliseconds."""
        return {}

    def _make_with_outputs(self, quantities: Sequence[str]) -> Plant:
        outputs = {quantity: self.offered[quantity] for quantity in quantities}
        seen = set().union(*(sp.sympify(self.expand(e)).free_symbols for e in outputs.values()))
        # A filter without an observer would cost time and add parameters that nothing identifies.
        system = self.behind if seen & set(self.behind.states) else NO_FILTER
        motion = (*self.rates, *self.initial)
        found = _parameters(self.blocks, self.inputs, self.terms, motion, self.switches, system, outputs)
        own = {s for s, _ in self.terms} | {*self.states, *self.behind.states}
        return replace(self, outputs=outputs, filter=system, parameters=tuple(s for s in found if s not in own))

    @cached_property
    def declarations(self) -> dict[str, Declaration]:
        """Parameters as named in the mechanism file: {dotted name: declaration}."""
        return {dotted_name(block, d.key): d for block in self.blocks for d in block.declarations}

    @cached_property
    def starts(self) -> dict[str, Declaration]:
        """Start values that a record may have of its own, by key, e.g. ``"start.angle"``."""
        moved = set().union(
            *(self.start_expressions.get(s, sp.Integer(0)).free_symbols for s in self.states_with_filter)
        )
        return {d.key: d for block in self.blocks for d in block.starts if sp.Symbol(d.symbol) in moved}

    @property
    def states_with_filter(self) -> tuple[sp.Symbol, ...]:
        """States of the plant, then of the filter."""
        return (*self.states, *self.filter.states)

    @cached_property
    def estimable(self) -> tuple[sp.Symbol, ...]:
        """Kernel parameters that may have sensitivities: all except counts such as poles and gear ratio."""
        fixed = {sp.Symbol(d.symbol) for d in self.declarations.values() if d.structural}
        return tuple(s for s in self.parameters if s not in fixed)

    @cached_property
    def coordinates(self) -> dict[sp.Symbol, sp.Expr]:
        """Each kernel parameter as a function of the file's symbols."""
        special = {s: e for block in self.blocks for s, e in block.coordinates.items()}
        return {s: special.get(s, s) for s in self.parameters}

    @cached_property
    def file_map(self) -> tuple[tuple[sp.Symbol, ...], tuple[sp.Expr, ...]]:
        """The file's symbols in the order of the declarations, and the kernel's parameters as functions of them.

        Two plants with the same equations may declare different parameters.
        """
        symbols = tuple(sp.Symbol(d.symbol) for d in self.declarations.values())
        return symbols, tuple(self.coordinates[s] for s in self.parameters)

    @cached_property
    def polar_pairs(self) -> tuple[PolarPair, ...]:
        """Amplitude-phase pairs, with dotted names."""
        return tuple(
            PolarPair(
                amplitude=dotted_name(block, pair.amplitude),
                phase=dotted_name(block, pair.phase),
                cosine=pair.cosine,
                sine=pair.sine,
                cycles=pair.cycles,
                of_phase=pair.of_phase,
            )
            for block in self.blocks
            for pair in block.polar
        )

    def related_parameters(self, relation: str) -> dict[str, str]:
        """Return the pairs of parameters in a relation, {dotted name: the other's}, if the plant has both.

        `relation` is a field of `Declaration` that names another parameter: above, beyond, part_of or tied_to.
        """
        pairs = {
            dotted_name(block, d.key): dotted_name(block, other)
            for block in self.blocks
            for d in block.declarations
            if (other := getattr(d, relation)) is not None
        }
        return {name: other for name, other in pairs.items() if other in self.declarations}

    def names_with_role(self, role: Role) -> tuple[str, ...]:
        """Return the dotted names of the parameters with a role."""
        return tuple(name for name, d in self.declarations.items() if d.role is role)

    @cached_property
    def of_record(self) -> dict[str, str]:
        """Parameters for which a record may have its own value: {name after ``record.<name>.``: dotted name}."""
        allowed = {name: d for name, d in self.declarations.items() if not d.structural}
        stand = {name: name for name in allowed if name.partition(".")[0] in OF_RECORD}
        motor = {d.key: name for name, d in allowed.items() if d.role and MOTOR_OF_RECORD.get(d.key) is d.role}
        return stand | motor

    @cached_property
    def start_angle_slopes(self) -> dict[sp.Symbol, sp.Expr]:
        """Mean rate d(initial)/d(theta_0) of each state that the start angle turns, averaged over a turn.

        Oscillating parts, such as a kinematic error, do not count.
        """
        # Without the amplitudes of harmonics only the mean rotation remains.
        harmonics = {part: 0 for pair in self.polar_pairs for part in (pair.cosine, pair.sine)}
        even = (sp.sympify(e).subs(harmonics) for e in self.initial)
        slopes = {s: sp.diff(e, START_ANGLE) for s, e in zip(self.states, even, strict=True)}
        return {s: slope for s, slope in slopes.items() if slope != 0}

    @cached_property
    def most_guards(self) -> int:
        """Largest number of guards of a mode."""
        return max((len(guards) for s in self.switches for guards in s.guards.values()), default=0)

    @cached_property
    def digest(self) -> str:
        """Hash of the structure: equations and their order, independent of parameter values."""
        text = structure_text
        switches = [(s.name, text(s.modes), text(s.guards), text(s.entry), s.otherwise) for s in self.switches]
        motion = (self.states, self.terms, self.rates, self.initial, self.inputs, switches)
        own, outputs = self.filter, tuple(self.outputs.items())
        parts = (*motion, own.states, own.inputs, own.A, own.B, outputs, self.parameters)
        return hashlib.sha256(text(parts).encode()).hexdigest()

    def __hash__(self) -> int:
        return hash(self.digest)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Plant) and other.digest == self.digest

    @cached_property
    def jump_switches(self) -> tuple[int, ...]:
        """Indices of the switches at which an output may jump, i.e. whose mode symbols enter an output."""
        seen = set().union(*(expr.free_symbols for expr in self.outputs.values()))
        for symbol, definition in reversed(self.terms):
            # Backwards, so that nested terms are found in one pass.
            if symbol in seen:
                seen |= definition.free_symbols
        modes = [set().union(*switch.modes.values()) for switch in self.switches]
        return tuple(i for i, symbols in enumerate(modes) if symbols & seen)

    def expand(self, expr: sp.Expr) -> sp.Expr:
        """Return `expr` with every named term replaced by its definition."""
        # Backwards: a definition contains earlier terms only.
        for symbol, definition in reversed(self.terms):
            expr = expr.subs(symbol, definition)
        return expr


def dotted_name(block: Block, key: str) -> str:
    """Return the name of a block's parameter in the mechanism file, e.g. ``"gear.stiffness"``."""
    return key if "." in key else f"{block.table}.{key}"


def assemble(
    name: str,
    blocks: Sequence[Block],
    wiring: Mapping[str, str],
    outputs: Mapping[str, str],
    measured: Sequence[str] | None = None,
) -> Plant:
    """Wire blocks into a plant.

    Parameters
    ----------
    name : str
    blocks : sequence of Block
    wiring : mapping
        ``"block.input"`` to ``"block.output"``. A missing input is wired to the only output with its
        name; if there is none, it is excitation of the plant.
    outputs : mapping
        Quantities that can be measured, to ``"block.output"``.
    measured : sequence of str or None
        Those of `outputs` that are measured; None for the first.

    Raises
    ------
    ValueError
        The wiring names unknown inputs or outputs, or closes a nonlinear algebraic loop; or two blocks
        share a name, a state or a term, or provide the same output where it is wired by name.
    """
    links = Links(blocks, wiring)
    terms = [(symbol, links.resolve(b, e)) for b in blocks for symbol, e in b.terms.items()]
    rates = {state: links.resolve(b, e) for b in blocks for state, e in b.rates.items()}
    initial = {state: links.resolve(b, e) for b in blocks for state, e in b.initial.items()}
    # At rest the start values of records are zero.
    unmoved = {sp.Symbol(d.symbol): 0 for b in blocks for d in b.starts}
    _refuse_twice([s for b in blocks for s in (*b.terms, *b.rates, *(b.filter.states if b.filter else ()))])
    switches = tuple(links.switch(b) for b in blocks if b.switch)
    ordered = sort_terms(terms)
    system = combine_filters(links, blocks, [s for s, _ in ordered])
    offered = {quantity: links.output(target) for quantity, target in outputs.items()}
    out = {quantity: offered[quantity] for quantity in measured or [*outputs][:1]}
    plant = Plant(
        name=name,
        blocks=tuple(blocks),
        states=tuple(rates),
        terms=ordered,
        rates=tuple(rates.values()),
        initial=start_states([initial[s].subs(unmoved) for s in rates], tuple(rates), ordered),
        start_expressions=dict(
            zip(initial, start_states(list(initial.values()), tuple(initial), ordered), strict=True)
        ),
        inputs=tuple(links.free_inputs),
        switches=switches,
        filter=system,
        behind=system,
        outputs=out,
        parameters=(),
        offered=offered,
    )
    # All outputs on offer are checked, not only those measured now.
    _refuse_unknown_symbols(plant, offered.values())
    return plant.with_outputs(tuple(out))


def _refuse_unknown_symbols(plant: Plant, offered: Iterable[sp.Expr]) -> None:
    """Refuse symbols that are not a state, term, input, mode symbol or declared parameter."""
    modes = {m for s in plant.switches for values in s.modes.values() for m in values}
    known = {*plant.states, *plant.filter.states, *plant.inputs, *modes, START_ANGLE, *(s for s, _ in plant.terms)}
    known |= {sp.Symbol(d.symbol) for d in plant.declarations.values()}
    known |= {s for block in plant.blocks for s in block.coordinates}
    margins = [g.margin for s in plant.switches for gs in s.guards.values() for g in gs]
    entries = [e for s in plant.switches for e, _ in s.entry]
    system = [*plant.filter.A, *plant.filter.B, *plant.filter.inputs]
    known |= {sp.Symbol(d.symbol) for block in plant.blocks for d in block.starts}
    every = [
        *(e for _, e in plant.terms),
        *plant.rates,
        *plant.start_expressions.values(),
        *margins,
        *entries,
        *system,
        *offered,
    ]
    if strange := sorted(str(s) for e in every for s in sp.sympify(e).free_symbols - known):
        raise ValueError(f"{strange[0]} is no state, term, input or declared parameter")


def _refuse_twice(symbols: Sequence[sp.Symbol]) -> None:
    seen: set[sp.Symbol] = set()
    for symbol in symbols:
        if symbol in seen:
            raise ValueError(f"two blocks have a state or term {symbol}")
        seen.add(symbol)


def _parameters(
    blocks: Sequence[Block],
    inputs: Sequence[sp.Symbol],
    terms: Sequence[tuple[sp.Symbol, sp.Expr]],
    rates: Sequence[sp.Expr],
    switches: Sequence[Switch],
    system: LinearSystem,
    outputs: Mapping[str, sp.Expr],
) -> tuple[sp.Symbol, ...]:
    """Return the kernel's parameters in the order of the blocks' declarations."""
    expressions = [e for _, e in terms] + list(rates) + list(outputs.values())
    expressions += [g.margin for s in switches for gs in s.guards.values() for g in gs]
    expressions += [*system.A, *system.B]
    used = set().union(*(sp.sympify(e).free_symbols for e in expressions))
    modes = {m for s in switches for values in s.modes.values() for m in values}
    own = modes | set(inputs)
    order: dict[sp.Symbol, None] = {}
    for block in blocks:
        # A value of the file gives its place to the first kernel parameter that depends on it.
        special = {e: s for s, expr in reversed(list(block.coordinates.items())) for e in expr.free_symbols}
        for d in block.declarations:
            order[special.get(sp.Symbol(d.symbol), sp.Symbol(d.symbol))] = None
        order |= dict.fromkeys(block.coordinates)
    return tuple(s for s in order if s in used - own)
