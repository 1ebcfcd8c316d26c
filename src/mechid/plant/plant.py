"""Blocks and wiring become one plant: states, ordered terms, rates, switches, filter, outputs."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from mechid.parameter import Declaration
from mechid.plant.block import Block, Guard, LinearSystem, PolarPair, Switch

START_ANGLE = sp.Symbol("theta_0")


@dataclass(frozen=True, kw_only=True, eq=False)
class Plant:
    """A wired plant as symbols; what the kernel generator, the twin and the docs are made from.

    Attributes
    ----------
    name : str
    blocks : tuple of Block
    states : tuple of Symbol, (n,)
        States of the nonlinear part.
    terms : tuple of (Symbol, Expr)
        In an order in which each needs only states, parameters, inputs, mode symbols and earlier terms.
    rates : tuple of Expr, (n,)
    initial : tuple of Expr, (n,)
        Functions of parameters, inputs and `START_ANGLE`.
    inputs : tuple of Symbol
        Excitation, e.g. the normalised phase voltages.
    switches : tuple of Switch
    filter : LinearSystem
        Closed-form linear part behind the plant; may be empty.
    outputs : mapping of quantity to Expr
        Functions of states, terms, filter states and parameters.
    parameters : tuple of Symbol
        The kernel's parameters, in order.
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

    @cached_property
    def declarations(self) -> dict[str, Declaration]:
        """Parameters as the mechanism file names them: {dotted name: declaration}."""
        return {dotted_name(block, d.key): d for block in self.blocks for d in block.declarations}

    @cached_property
    def estimable(self) -> tuple[sp.Symbol, ...]:
        """Kernel parameters that may have sensitivities: all but counts such as poles and gear ratio."""
        fixed = {sp.Symbol(d.symbol) for d in self.declarations.values() if d.structural}
        return tuple(s for s in self.parameters if s not in fixed)

    @cached_property
    def coordinates(self) -> dict[sp.Symbol, sp.Expr]:
        """Each kernel parameter as a function of the file's symbols."""
        special = {s: e for block in self.blocks for s, e in block.coordinates.items()}
        return {s: special.get(s, s) for s in self.parameters}

    @cached_property
    def polar_pairs(self) -> tuple[PolarPair, ...]:
        """Amplitude-phase pairs, with dotted names."""
        return tuple(
            PolarPair(
                amplitude=dotted_name(block, pair.amplitude),
                phase=dotted_name(block, pair.phase),
                cosine=pair.cosine,
                sine=pair.sine,
            )
            for block in self.blocks
            for pair in block.polar
        )

    @cached_property
    def digest(self) -> str:
        """Fingerprint of the structure: equations and order, no number of any mechanism."""
        switches = [(s.name, _text(s.modes), _text(s.guards), _text(s.entry), s.otherwise) for s in self.switches]
        parts = (
            self.states, self.terms, self.rates, self.initial, self.inputs, switches,
            self.filter.states, self.filter.inputs, self.filter.A, self.filter.B,
            tuple(self.outputs.items()), self.parameters,
        )  # fmt: skip
        return hashlib.sha256(_text(parts).encode()).hexdigest()

    def __hash__(self) -> int:
        return hash(self.digest)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Plant) and other.digest == self.digest

    def expand(self, expr: sp.Expr) -> sp.Expr:
        """Return `expr` with every named term replaced by its definition."""
        for symbol, definition in reversed(self.terms):
            expr = expr.subs(symbol, definition)
        return expr


def _text(value: object) -> str:
    """Return a text that is the same in every process for the same symbolic value."""
    if isinstance(value, Guard):
        return f"guard({_text(value.margin)},{value.target},{_text(value.resets)})"
    if isinstance(value, Mapping):
        return "{" + ",".join(f"{_text(k)}:{_text(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "(" + ",".join(map(_text, value)) + ")"
    return sp.srepr(value) if isinstance(value, sp.Basic | sp.MatrixBase) else repr(value)


def dotted_name(block: Block, key: str) -> str:
    """Return the name of a block's parameter in the mechanism file, e.g. ``"gear.stiffness"``."""
    return key if "." in key else f"{block.table}.{key}"


def assemble(name: str, blocks: Sequence[Block], wiring: Mapping[str, str], outputs: Mapping[str, str]) -> Plant:
    """Wire blocks into a plant.

    Parameters
    ----------
    name : str
    blocks : sequence of Block
    wiring : mapping
        ``"block.input"`` to ``"block.output"``. An input that is not wired is excitation of the plant.
    outputs : mapping
        Quantity to ``"block.output"``.

    Raises
    ------
    ValueError
        If the wiring names what is not there, or closes an algebraic loop that is not linear.
    """
    links = _Links(blocks, wiring)
    terms = [(symbol, links.resolve(b, e)) for b in blocks for symbol, e in b.terms.items()]
    rates = {state: links.resolve(b, e) for b in blocks for state, e in b.rates.items()}
    initial = {state: links.resolve(b, e) for b in blocks for state, e in b.initial.items()}
    switches = tuple(_resolve_switch(links, b) for b in blocks if b.switch)
    ordered = _ordered(terms)
    system = _joined_filter([(links, b) for b in blocks if b.filter])
    out = {quantity: links.output(target) for quantity, target in outputs.items()}
    return Plant(
        name=name,
        blocks=tuple(blocks),
        states=tuple(rates),
        terms=ordered,
        rates=tuple(rates.values()),
        initial=tuple(_expand(e, ordered) for e in (sp.sympify(initial[s]) for s in rates)),
        inputs=tuple(links.free_inputs),
        switches=switches,
        filter=system,
        outputs=out,
        parameters=_parameters(blocks, links, ordered, rates, switches, system, out),
    )


class _Links:
    """The wiring of one assembly: replaces each block's input symbols by what they are wired to."""

    def __init__(self, blocks: Sequence[Block], wiring: Mapping[str, str]) -> None:
        self.blocks = {b.name: b for b in blocks}
        self.wiring = wiring
        inputs = {f"{b.name}.{s.name.removesuffix('_in')}": s for b in blocks for s in b.inputs}
        if unknown := set(wiring) - set(inputs):
            raise ValueError(f"wiring of unknown inputs {sorted(unknown)}; known: {sorted(inputs)}")
        self.free_inputs = [s for key, s in inputs.items() if key not in wiring]

    def output(self, target: str) -> sp.Expr:
        name, _, key = target.partition(".")
        if name not in self.blocks or key not in self.blocks[name].outputs:
            raise ValueError(f"no output {target!r}")
        block = self.blocks[name]
        return self.resolve(block, block.outputs[key])

    def resolve(self, block: Block, expr: sp.Expr) -> sp.Expr:
        expr = sp.sympify(expr)
        used = [s for s in block.inputs if expr.has(s)]
        keys = {s: f"{block.name}.{s.name.removesuffix('_in')}" for s in used}
        wired = {s: self.output(self.wiring[key]) for s, key in keys.items() if key in self.wiring}
        return expr.xreplace(wired)


def _resolve_switch(links: _Links, block: Block) -> Switch:
    switch = block.switch
    assert switch is not None

    def resolved(guard: Guard) -> Guard:
        return Guard(margin=links.resolve(block, guard.margin), target=guard.target, resets=guard.resets)

    return Switch(
        name=switch.name,
        modes=switch.modes,
        guards={mode: tuple(map(resolved, guards)) for mode, guards in switch.guards.items()},
        entry=tuple((links.resolve(block, e), mode) for e, mode in switch.entry),
        otherwise=switch.otherwise,
        ideal=switch.ideal,
    )


def _joined_filter(parts: Iterable[tuple[_Links, Block]]) -> LinearSystem:
    """Put the blocks' filters into one system; they run side by side."""
    systems = [
        (f.states, [links.resolve(b, s) for s in f.inputs], f.A, f.B)
        for links, b in parts
        if (f := b.filter) is not None
    ]
    states = tuple(s for system in systems for s in system[0])
    inputs = tuple(dict.fromkeys(u for system in systems for u in system[1]))
    B = sp.zeros(len(states), len(inputs))
    row = 0
    for own, used, _, gain in systems:
        for j, u in enumerate(used):
            B[row : row + len(own), inputs.index(u)] = gain[:, j]
        row += len(own)
    A = sp.diag(*(system[2] for system in systems)) if systems else sp.zeros(0, 0)
    return LinearSystem(states=states, inputs=inputs, A=sp.Matrix(A), B=B)


def _ordered(terms: Sequence[tuple[sp.Symbol, sp.Expr]]) -> tuple[tuple[sp.Symbol, sp.Expr], ...]:
    """Sort terms so that each comes after what it needs; a linear loop is solved for its terms."""
    pending = dict(terms)
    known: dict[sp.Symbol, sp.Expr] = {}
    while pending:
        ready = [s for s, e in pending.items() if not e.free_symbols & pending.keys()]
        if not ready:
            solution = _solve_loop(pending)
            known |= solution
            break
        known |= {s: pending.pop(s) for s in ready}
    return tuple(known.items())


def _solve_loop(terms: Mapping[sp.Symbol, sp.Expr]) -> dict[sp.Symbol, sp.Expr]:
    try:
        solution = sp.linsolve([s - e for s, e in terms.items()], list(terms))
    except sp.solvers.solveset.NonlinearError as error:
        raise ValueError(f"algebraic loop through {list(terms)} is not linear") from error
    return dict(zip(terms, next(iter(solution)), strict=True))


def _expand(expr: sp.Expr, terms: Sequence[tuple[sp.Symbol, sp.Expr]]) -> sp.Expr:
    for symbol, definition in reversed(terms):
        expr = expr.subs(symbol, definition)
    return expr


def _parameters(
    blocks: Sequence[Block],
    links: _Links,
    terms: Sequence[tuple[sp.Symbol, sp.Expr]],
    rates: Mapping[sp.Symbol, sp.Expr],
    switches: Sequence[Switch],
    system: LinearSystem,
    outputs: Mapping[str, sp.Expr],
) -> tuple[sp.Symbol, ...]:
    """Collect the kernel's parameters in the order of the blocks' declarations."""
    expressions = [e for _, e in terms] + list(rates.values()) + list(outputs.values())
    expressions += [g.margin for s in switches for gs in s.guards.values() for g in gs]
    expressions += [*system.A, *system.B]
    used = set().union(*(sp.sympify(e).free_symbols for e in expressions))
    modes = {m for s in switches for values in s.modes.values() for m in values}
    own = {s for s, _ in terms} | set(rates) | set(links.free_inputs) | set(system.states) | modes
    order: dict[sp.Symbol, None] = {}
    for block in blocks:
        special = {e: s for s, expr in reversed(list(block.coordinates.items())) for e in expr.free_symbols}
        for d in block.declarations:
            order[special.get(sp.Symbol(d.symbol), sp.Symbol(d.symbol))] = None
        order |= dict.fromkeys(block.coordinates)
    return tuple(s for s in order if s in used - own)
