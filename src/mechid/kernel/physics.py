"""Plant-specific functions of a kernel as Python text: rates, guards, outputs, start.

Every function reads its numbers from arrays: a point `x` (the states, then sine and cosine of each base
angle), filter states `z`, inputs `u`, mode symbols `m`, constants `c` (functions of parameters `p` alone),
rates `k`, the lane workspace `w`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import sympy as sp

from mechid.kernel.expressions import Angles, Constants, python_text
from mechid.kernel.places import Places
from mechid.kernel.program import Program
from mechid.kernel.schedule import schedule
from mechid.plant.plant import START_ANGLE, Plant

MANY = 1000
"""Number of operations from which the start is written with shared subexpressions, to save compilation time."""
NJIT = "@njit(**INNER, fastmath=FAST{inline})"
Assignments = Sequence[tuple[str, sp.Expr]]


@dataclass(frozen=True)
class Body:
    """Lines of a computation: loads of values that change within a step, loads of constant values, and computation."""

    moving: list[str]
    held: list[str]
    computed: list[str]

    @property
    def lines(self) -> list[str]:
        """All lines, in order."""
        return [*self.moving, *self.held, *self.computed]


@dataclass
class Writer:
    """Writes the functions of one plant, which share constants, angles and the workspace layout."""

    plant: Plant
    at: Places = field(default_factory=Places)
    program: Program = field(init=False)
    constants: Constants = field(init=False)
    angles: Angles = field(init=False)

    def __post_init__(self) -> None:
        self.program = Program(self.plant)
        fixed = frozenset(self.plant.parameters)
        self.constants = Constants(fixed)
        self.angles = Angles(fixed)
        self.angles.collect([*(e for _, e in self.plant.terms), *self.plant.rates])

    @property
    def mode_symbols(self) -> tuple[sp.Symbol, ...]:
        """Symbols of all switches' modes, in order."""
        values = [next(iter(s.modes.values())) for s in self.plant.switches]
        return tuple(m for v in values for m in v)

    @property
    def held_arguments(self) -> list[str]:
        """Inputs and mode symbols as arguments; they are constant over a step."""
        inputs = [self.at.u[i] for i in range(len(self.plant.inputs))]
        return inputs + [self.at.m[i] for i in range(len(self.mode_symbols))]

    @property
    def point(self) -> tuple[sp.Symbol, ...]:
        """States, then sine and cosine of each base angle."""
        return (*self.plant.states, *self.angles.pairs)

    @property
    def unpacked_arguments(self) -> str:
        """All scalar arguments of the rates, read from the workspace."""
        return ", ".join(self._point_places + self.held_arguments)

    def body(self, wanted: Assignments, *, scalars: Iterable[sp.Symbol] = (), share: bool = False) -> list[str]:
        """Return the lines of `parts` as one list."""
        return self.parts(wanted, scalars=scalars, share=share).lines

    def parts(
        self,
        wanted: Assignments,
        *,
        scalars: Iterable[sp.Symbol] = (),
        share: bool = False,
        point: Sequence[str] | None = None,
    ) -> Body:
        """Return the lines that compute `wanted` ({target: expression}).

        `scalars` are symbols that are local already. All other symbols are read from the arrays, the point
        from `point` or from `x_at` on. With `share`, repeated subexpressions get a name (``r0``, ``r1``, ...).
        """
        terms = self._needed_terms(wanted)
        assignments = [(str(s), e) for s, e in terms] + list(wanted)
        turned = [(name, self.angles.replace(e)) for name, e in assignments]
        ready = [(name, self.constants.hoist(e)) for name, e in turned]
        multiples = self.angles.multiples([e for _, e in ready])
        if share:
            # order="none" skips SymPy's canonical ordering, which is slow for large expressions.
            shared, reduced = sp.cse([e for _, e in ready], symbols=sp.numbered_symbols("r"), order="none")
            pairs = zip(ready, reduced, strict=True)
            ready = _in_order(shared, [(name, e) for (name, _), e in pairs])
        lines = [*multiples, *ready]
        # These are known before the step's first stage, unlike all that depends on the states.
        early = {*self.constants.names.values(), *self.plant.inputs, *self.mode_symbols}
        texts = [f"{name} = {text}" for name, text in schedule(lines, early)]
        moving, held = self._loads([e for _, e in lines], set(scalars), point or self._point_places)
        return Body(moving, held, texts)

    def expression_loads(self, expressions: Sequence[sp.Expr]) -> list[str]:
        """Return the lines that load all symbols of some expressions."""
        moving, held = self._loads(expressions, set(), self._point_places)
        return [*moving, *held]

    @property
    def _point_places(self) -> list[str]:
        return [self.at.x[i] for i in range(len(self.point))]

    def _needed_terms(self, wanted: Assignments) -> list[tuple[sp.Symbol, sp.Expr]]:
        expressions, names = [e for _, e in wanted], {name for name, _ in wanted}
        definitions = {s: e for s, e in self.plant.terms if str(s) not in names}
        needed: set[sp.Symbol] = set()
        todo = {s for e in expressions for s in sp.sympify(e).free_symbols & definitions.keys()}
        while todo:
            needed |= todo
            todo = {s for t in todo for s in definitions[t].free_symbols & definitions.keys()} - needed
        return [(s, e) for s, e in definitions.items() if s in needed]

    def _loads(
        self, expressions: Sequence[sp.Expr], scalars: set[sp.Symbol], point: Sequence[str]
    ) -> tuple[list[str], list[str]]:
        """Return the loads of values that change within a step, and those of constant values."""
        seen = set().union(*(sp.sympify(e).free_symbols for e in expressions)) - scalars
        moving = [f"{s} = {place}" for s, place in zip(self.point, point, strict=True) if s in seen]
        moving += [f"{s} = {self.at.z[k]}" for k, s in enumerate(self.plant.filter.states) if s in seen]
        held = [f"{s} = {self.at.u[k]}" for k, s in enumerate(self.plant.inputs) if s in seen]
        held += [f"{s} = {self.at.m[k]}" for k, s in enumerate(self.mode_symbols) if s in seen]
        return moving, held + [f"{s} = {self.at.c[k]}" for k, s in self.constants.used_in(expressions)]


def _in_order(shared: Sequence[tuple[sp.Symbol, sp.Expr]], wanted: Assignments) -> list[tuple[str, sp.Expr]]:
    """Order repeated subexpressions first, except that those of named quantities come just before their first use."""
    waiting, ready = {}, []
    late = {sp.Symbol(name) for name, _ in wanted}
    for s, e in shared:
        if e.free_symbols & late:
            waiting[s] = e
            late.add(s)
        else:
            ready.append((str(s), e))
    for name, expr in wanted:
        needed, todo = set(), expr.free_symbols & waiting.keys()
        while todo:
            needed |= todo
            todo = set().union(*(waiting[s].free_symbols for s in todo)) & waiting.keys() - needed
        ready += [(str(s), waiting.pop(s)) for s in list(waiting) if s in needed]
        ready.append((name, expr))
    return ready


def function(
    name: str,
    arguments: str,
    doc: str,
    lines: Iterable[str],
    *,
    inline: bool | None = None,
    returns: str = "None",
) -> str:
    """Return the text of one compiled function; the argument types follow from the argument names.

    `inline` says whether it becomes part of its callers; None leaves that to the compiler.
    """
    lines = ["apart()", *lines] if inline is False else lines
    body = "\n".join(f"    {line}" for line in lines)
    # Without forceinline=False a function has it from its first caller.
    head = NJIT.format(inline="" if inline is None else f", forceinline={inline}")
    typed = ", ".join(f"{argument}: {_type_of(argument)}" for argument in arguments.split(", "))
    return f'{head}\ndef {name}({typed}) -> {returns}:\n    """{doc}"""\n{body}\n'


def _type_of(argument: str) -> str:
    """Return the type of an argument: an array, an integer (position, switch, mode or guard), or a float."""
    if argument.endswith("_") and len(argument) == len("w_"):
        return "Numbers"
    return "int" if argument.endswith("_at") or argument in ("at", "to", "s", "mode", "g") else "float"


def rates(writer: Writer) -> list[str]:
    """Write rates and filter inputs, as a function of scalars and as one of arrays."""
    plant, fed, at = writer.plant, writer.program.filter_inputs, writer.at
    scalars = (*writer.point, *plant.inputs, *writer.mode_symbols)
    wanted = [(f"k_{s}", e) for s, e in zip(plant.states, plant.rates, strict=True)]
    wanted += [(f"v_{k}", e) for k, e in enumerate(fed)]
    names = ", ".join(name for name, _ in wanted)
    lines = [*writer.body(wanted, scalars=scalars), f"return {names}"]
    arguments = ", ".join(map(str, scalars))
    fill = [f"{names} = rates_of({writer.unpacked_arguments}, w_)"]
    fill += [f"{at.k[i]} = {name}" for i, (name, _) in enumerate(wanted)]
    return [
        function(
            "rates_of",
            f"{arguments}, w_",
            "Rates of the states, then inputs of the filter.",
            lines,
            inline=True,
            returns=f"tuple[{', '.join(['float'] * len(wanted))}]",
        ),
        function("rates", "w_, x_at, k_at", "The same from x_at to k_at.", fill, inline=True),
    ]


def start(writer: Writer) -> str:
    """Write states and sensitivities at the start of a record, with the coil currents settled at the first voltages."""
    plant, at = writer.plant, writer.at
    reads = [f"{q} = {at.p[k]}" for k, q in enumerate(plant.parameters) if _has(plant.initial, q)]
    reads += [f"{u} = {at.u[k]}" for k, u in enumerate(plant.inputs) if _has(plant.initial, u)]
    wanted = [(at.x[i], sp.sympify(e)) for i, e in enumerate(plant.initial)]
    wanted += [
        (at.x_p[i * len(plant.parameters) + k], d)
        for i, e in enumerate(plant.initial)
        for k, q in enumerate(plant.parameters)
        if (d := sp.diff(e, q)) != 0
    ]
    lines = [f"{name} = {python_text(e)}" for name, e in _shared_if_long(wanted)]
    return function(
        "start", f"p_, {START_ANGLE}, w_, x_at", "States at the start and their derivatives to p.", reads + lines
    )


def _shared_if_long(wanted: Assignments) -> list[tuple[str, sp.Expr]]:
    """Return the assignments; long ones, such as settled currents behind a source, with shared subexpressions."""
    # Short starts compile fast as they are, and stay readable.
    if sum(int(e.count_ops()) for _, e in wanted) < MANY:
        return list(wanted)
    shared, reduced = sp.cse([e for _, e in wanted], symbols=sp.numbered_symbols("r"))
    return [(str(s), e) for s, e in shared] + [(name, e) for (name, _), e in zip(wanted, reduced, strict=True)]


def _has(expressions: Iterable[sp.Expr], symbol: sp.Symbol) -> bool:
    return any(sp.sympify(e).has(symbol) for e in expressions)


def outputs(writer: Writer) -> list[str]:
    """Write the outputs, and their gradients with respect to states, filter states and parameters."""
    plant, program, at = writer.plant, writer.program, writer.at
    wanted = [(at.y[f"at + {j}"], e) for j, e in enumerate(plant.outputs.values())]
    every = (*plant.states, *plant.filter.states)
    gradient: list[tuple[str, sp.Expr]] = []
    for j, node in enumerate(program.output_nodes):
        gradient += [(at.y_x[j * len(every) + i], node.inner.get(s, sp.Integer(0))) for i, s in enumerate(every)]
        gradient += [
            (at.y_p[j * len(plant.parameters) + k], d)
            for k, q in enumerate(plant.parameters)
            if (d := node.outer.get(q))
        ]
    return [
        function("outputs", "w_, x_at, y_, at", "Measured quantities.", [*writer.body(wanted), "return"], inline=True),
        _output_flow(writer),
        function(
            "output_gradient",
            "w_, x_at",
            "Their gradients; y_p holds zeros elsewhere.",
            [*writer.body(gradient, share=True), "return"],
            inline=True,
        ),
    ]


def _output_flow(writer: Writer) -> str:
    """Write the time derivatives of the outputs: gradients along the rates and the filter's flow."""
    plant, width, at = writer.plant, len(writer.plant.filter.inputs), writer.at
    states, z = plant.states, plant.filter.states
    rates = {s: sp.Symbol(f"k_{s}") for s in (*states, *z)}
    lines = [f"k_{s} = {at.k[i]}" for i, s in enumerate(states)]
    for i, s in enumerate(z):
        parts = [f"{at.A[i * len(z) + j]} * {at.z[j]}" for j in range(len(z)) if plant.filter.A[i, j] != 0]
        parts += [f"{at.B[i * width + j]} * {at.k[len(states) + j]}" for j in range(width) if plant.filter.B[i, j] != 0]
        lines.append(f"k_{s} = " + (" + ".join(parts) or "0.0"))
    flows = [
        (at.y[f"at + {j}"], sp.Add(*(d * rates[s] for s, d in node.inner.items() if s in rates)))
        for j, node in enumerate(writer.program.output_nodes)
    ]
    lines += writer.body(flows, scalars=rates.values(), share=True)
    return function("output_flow", "w_, x_at, k_at, y_, at", "Their time derivatives.", [*lines, "return"], inline=True)


def linear_filter(writer: Writer) -> str:
    """Write the matrices of the filter and their derivatives with respect to the parameters in them."""
    plant, at = writer.plant, writer.at
    system, lines = plant.filter, []
    own = filter_parameters(plant)
    used = set().union(*(e.free_symbols for e in [*system.A, *system.B]), set())
    reads = [f"{q} = {at.p[k]}" for k, q in enumerate(plant.parameters) if q in used]
    for values, slopes, matrix in ((at.A, at.dA, system.A), (at.B, at.dB, system.B)):
        for (i, j), e in _entries(matrix):
            place = i * matrix.cols + j
            lines.append(f"{values[place]} = {python_text(e)}")
            lines += [
                f"{slopes[f * len(matrix) + place]} = {python_text(d)}"
                for f, q in enumerate(own)
                if (d := sp.diff(e, q)) != 0
            ]
    doc = "x' = A x + B v, with dA, dB to the filter's own parameters."
    return function("filter_matrices", "p_, w_", doc, [*reads, *lines, "return"])


def _entries(matrix: sp.Matrix) -> Iterable[tuple[tuple[int, int], sp.Expr]]:
    for i in range(matrix.rows):
        for j in range(matrix.cols):
            if matrix[i, j] != 0:
                yield (i, j), matrix[i, j]


def filter_parameters(plant: Plant) -> tuple[sp.Symbol, ...]:
    """Return the estimable parameters in the filter's matrices, in the kernel's order."""
    used = set().union(*(e.free_symbols for e in [*plant.filter.A, *plant.filter.B]), set())
    return tuple(q for q in plant.estimable if q in used)


def constants(writer: Writer) -> str:
    """Write all hoisted constants; must come last, when they are all known."""
    names, at = writer.constants.names, writer.at
    used = set().union(*(e.free_symbols for e in names), set())
    reads = [f"{q} = {at.p[k]}" for k, q in enumerate(writer.plant.parameters) if q in used]
    lines = [
        f"{at.c[k]} = {python_text(e)}" + ("" if e.is_Symbol else f"  # {s}") for k, (e, s) in enumerate(names.items())
    ]
    return function("constants", "p_, w_", "Functions of the parameters alone.", [*reads, *lines, "return"])
