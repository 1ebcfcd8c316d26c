"""Sensitivity lanes of a kernel as Python text: the variational equations of all parameters in parallel.

Lane l holds dx/dq for one direction q in the space of parameters. Lanes come in groups of `WIDTH`; the rows of a group
are contiguous in the flat workspace, so that one pass over a group keeps its lanes in the processor's registers through
a whole step. Their factors, the tangent program's coefficients at the points of the step's stages, are stored
beforehand by `tangents`. The partial derivative of a parameter enters every lane in proportion to the lane's direction
(rows DIR), so that ties and search coordinates cost nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from mechid.kernel.expressions import python_text
from mechid.kernel.physics import Writer, filter_parameters, function
from mechid.kernel.program import Node

WIDTH = 4
"""Lanes per group."""
STAGES = ("1", "2", "3", "4")
"""Points of a step, after its start, at which tangents are computed: three stages and the end."""


@dataclass(frozen=True)
class Layout:
    """Rows of a group, each of `WIDTH` lanes."""

    states: int
    filter_states: int
    fed: int
    parameters: int
    forced: int
    outputs: int

    @cached_property
    def rows(self) -> dict[str, int]:
        """First row of each part, and the total under ``"END"``."""
        sizes = {
            "S": self.states,
            "SZ": self.filter_states,
            "K": self.states,
            "V": self.fed,
            "DIR": self.parameters,
            "DTAU": 1,
            "FORCE": len(STAGES) * self.forced,
            "OWN": self.filter_states,
            "Y": self.outputs,
        }
        first, out = 0, {}
        for name, size in sizes.items():
            out[name] = first
            first += size
        return out | {"END": first}


class LaneWriter:
    """Writes the lane functions of one plant."""

    def __init__(self, writer: Writer) -> None:
        self.writer = writer
        program = writer.program
        self.nodes: tuple[Node, ...] = (*program.nodes, *(n for n in program.filter_nodes if not self._is_shared(n)))
        self.seeded = [n for n in self.nodes if n.outer]
        self.layout = Layout(
            len(program.states),
            len(program.filter_states),
            len(program.filter_inputs),
            len(program.plant.parameters),
            len(self.seeded),
            len(program.output_nodes),
        )
        self._coefficients: dict[str, sp.Expr] = {}
        self._slopes = {n.symbol: {v: self._coefficient(n, v, d) for v, d in n.inner.items()} for n in self.nodes}
        self._seeds = {n.symbol: {q: self._name(n, q, d) for q, d in n.outer.items()} for n in self.seeded}

    @property
    def coefficients(self) -> int:
        """Number of coefficients that change in time."""
        return len(self._coefficients)

    @property
    def drive_parameters(self) -> list[int]:
        """Indices of the parameters that affect anything but the filter and the outputs."""
        plant = self.writer.plant
        guards = [g.margin for s in plant.switches for gs in s.guards.values() for g in gs]
        moved = {q for n in self.nodes for q in n.outer}
        for e in (*plant.initial, *map(plant.expand, guards)):
            moved |= sp.sympify(e).free_symbols
        return [k for k, q in enumerate(plant.parameters) if q in moved]

    @property
    def tables(self) -> list[str]:
        """Seeds as text: the first of each node that has some, and of each seed its coefficient and its parameter."""
        order, places = self.writer.plant.parameters, list(self._coefficients)
        first, coefficients, parameters = [0], [], []
        for row in self._seeds.values():
            coefficients += [places.index(name) for name in row.values()]
            parameters += [order.index(q) for q in row]
            first.append(len(parameters))
        return [
            f"SEED_FIRST = np.array({first})",
            f"SEED_COEFFICIENT = np.array({coefficients or [0]})",
            f"SEED_PARAMETER = np.array({parameters or [0]})",
        ]

    @property
    def seeds(self) -> int:
        """Number of pairs of a node and a parameter that affects it directly."""
        return sum(map(len, self._seeds.values()))

    def functions(self) -> list[str]:
        """Return all lane functions."""
        return [
            self._tangent(),
            self._lane_rates(),
            self._carry_lanes(),
            self._carry_filter_lanes(),
            self._force_filter(),
            self._measure_group(),
        ]

    def _is_shared(self, node: Node) -> bool:
        index = int(node.symbol.name.removeprefix("v_"))
        return self.writer.program.filter_inputs[index] in self.writer.program.shared_terms

    def _coefficient(self, node: Node, variable: sp.Symbol, derivative: sp.Expr) -> str:
        """Return the text of a partial derivative; one that varies in time gets a name and a position."""
        ready = self.writer.constants.hoist(self.writer.angles.replace(derivative))
        names = set(self.writer.constants.names.values())
        # Constant coefficients are read directly, without a place for each stage.
        return python_text(ready) if ready.free_symbols <= names else self._name(node, variable, derivative)

    def _name(self, node: Node, variable: sp.Symbol, derivative: sp.Expr) -> str:
        """Give a partial derivative a name and a position for each stage."""
        name = f"d_{node.symbol}_{variable}"
        self._coefficients[name] = derivative
        return name

    def _tangent(self) -> str:
        """Write the coefficients at all points of a step, the points in parallel as lanes."""
        at = self.writer.at
        wanted = [(at.tangent[f"{4 * i} + l"], e) for i, e in enumerate(self._coefficients.values())]
        n = len(self.writer.point)
        point = [at.packed[f"{4 * i} + l"] for i in range(n)]
        found = self.writer.parts(wanted, share=True, point=point)
        body = [*found.moving, *found.computed]
        used = [i for i in range(n) if any(point[i] in line for line in found.moving)]
        pack = [
            f"put_four(w_, AT_PACKED + {4 * i}, " + ", ".join(at.points[s * n + i] for s in range(4)) + ", w_[AT_ONE])"
            for i in used
        ]
        doc = "Coefficients of the tangent program at the points of a step."
        return function(
            "tangents", "w_", doc, [*pack, *found.held, "for l in range(4):", *(f"    {line}" for line in body)]
        )

    def _constant_loads(self) -> list[str]:
        texts = [t for part in (self._slopes, self._seeds) for row in part.values() for t in row.values()]
        used = [sp.Symbol(t.lstrip("-")) for t in texts]
        return [f"{s} = {self.writer.at.c[k]}" for k, s in self.writer.constants.used_in(used)]

    def _coefficient_loads(self, stage: str) -> list[str]:
        tangent, point = self.writer.at.tangent, STAGES.index(stage)
        used = {text for row in self._slopes.values() for text in row.values()}
        return [
            f"{name}_{stage} = {tangent[4 * i + point]}" for i, name in enumerate(self._coefficients) if name in used
        ]

    def _force_loads(self, stage: str) -> list[str]:
        point = STAGES.index(stage)
        rows = [(n.symbol, len(STAGES) * k + point) for k, n in enumerate(self.seeded)]
        return [f"f_{symbol}_{stage} = {self._row('FORCE', row)}" for symbol, row in rows]

    def _flow_lines(self, stage: str) -> list[str]:
        """Return the tangents of all nodes from ``y_<state>_<stage>``, inside a loop over l."""
        lines = []
        for node in self.nodes:
            forced = [f"f_{node.symbol}_{stage}"] if node.outer else []
            early: list[str] = []
            late: list[str] = []
            for v, text in self._slopes[node.symbol].items():
                shared = v in self.writer.program.shared_terms
                product = self._product(text, f"t_{v}_{stage}" if shared else f"y_{v}_{stage}", stage)
                (late if shared else early).append(product)
            parts = [*_in_halves([*forced, *early]), *late]
            lines.append(f"t_{node.symbol}_{stage} = {' + '.join(parts) or '0.0'}")
        return lines

    def _product(self, factor: str, variable: str, stage: str) -> str:
        if factor == "1.0":
            return variable
        if factor == "-1.0":
            return f"-{variable}"
        return f"{factor}_{stage} * {variable}" if factor in self._coefficients else f"{factor} * {variable}"

    def _fed_tangent(self, j: int, stage: str) -> str:
        source = self.writer.program.filter_inputs[j]
        return f"t_{source}_{stage}" if source in self.writer.program.shared_terms else f"t_v_{j}_{stage}"

    def _row(self, part: str, index: int) -> str:
        return self.writer.at.w[f"g + {(self.layout.rows[part] + index) * WIDTH} + l"]

    def _group_function(
        self, name: str, arguments: str, doc: str, before: list[str], body: list[str], *, inline: bool | None = None
    ) -> str:
        """Write one pass over the lanes of the group at position g."""
        lines = [*before, f"for l in range({WIDTH}):", *(f"    {line}" for line in body)]
        return function(name, arguments, doc, lines, inline=inline)

    def _lane_rates(self) -> str:
        states = self.writer.plant.states
        body = [f"y_{s}_4 = {self._row('S', i)}" for i, s in enumerate(states)]
        body += [*self._force_loads("4"), *self._flow_lines("4")]
        body += [f"{self._row('K', i)} = t_k_{s}_4" for i, s in enumerate(states)]
        body += [f"{self._row('V', j)} = {self._fed_tangent(j, '4')}" for j in range(self.layout.fed)]
        doc = "Rates K and filter inputs V of a group's lanes where they stand, by the last coefficients."
        before = [*self._constant_loads(), *self._coefficient_loads("4")]
        return self._group_function("lane_rates", "w_, g", doc, before, body, inline=False)

    def _carry_lanes(self) -> str:
        """Write the step of a group: classical Runge-Kutta, then the filter; K and V are left at the step's end."""
        states, n_fed = self.writer.plant.states, self.layout.fed
        before = self._constant_loads()
        # All coefficients are loaded before the loop, so that it runs in registers.
        for stage in STAGES:
            before += self._coefficient_loads(stage)
        before += ["half = 0.5 * h", "sixth = h / 6.0", *self._filter_loads(own=False)]
        body = [f"s_{s} = {self._row('S', i)}" for i, s in enumerate(states)]
        body += [f"k_{s} = {self._row('K', i)}" for i, s in enumerate(states)]
        body += [f"v_{j} = {self._row('V', j)}" for j in range(n_fed)]
        for stage in STAGES:
            body += self._force_loads(stage)
        for stage, reach, rate in (("1", "half", "k_{}"), ("2", "half", "t_k_{}_1"), ("3", "h", "t_k_{}_2")):
            body += [f"y_{s}_{stage} = s_{s} + {reach} * {rate.format(s)}" for s in states]
            body += self._flow_lines(stage)
        body += [f"y_{s}_4 = s_{s} + sixth * ((k_{s} + t_k_{s}_3) + 2.0 * (t_k_{s}_1 + t_k_{s}_2))" for s in states]
        body += self._flow_lines("4")
        for j in range(n_fed):
            one, two, three = (self._fed_tangent(j, stage) for stage in STAGES[:3])
            body.append(f"m_{j} = 0.5 * ({one} + {two}) + 0.25 * {three}")
        body += self._filter_lines(
            [
                *(f"v_{j}" for j in range(n_fed)),
                *(f"m_{j}" for j in range(n_fed)),
                *(self._fed_tangent(j, "4") for j in range(n_fed)),
            ],
            forced=True,
        )
        body += [f"{self._row('S', i)} = y_{s}_4" for i, s in enumerate(states)]
        body += [f"{self._row('K', i)} = t_k_{s}_4" for i, s in enumerate(states)]
        body += [f"{self._row('V', j)} = {self._fed_tangent(j, '4')}" for j in range(n_fed)]
        doc = "A step of length h of the lanes of the group at g, along the coefficients of its stages."
        return self._group_function("carry_lanes", "w_, g, h, prop_at", doc, before, body, inline=False)

    def _carry_filter_lanes(self) -> str:
        """Write the step of a group whose lanes affect the filter's own parameters only."""
        body = self._filter_lines(["0.0"] * (3 * self.layout.fed), forced=False)
        doc = "As carry_lanes, where only parameters of the filter move."
        return self._group_function(
            "carry_filter_lanes", "w_, g, prop_at", doc, self._filter_loads(own=True), body or ["pass"]
        )

    def _force_filter(self) -> str:
        """Write what the filter's own parameters add to a group's filter states over a step."""
        n, own = self.layout.filter_states, filter_parameters(self.writer.plant)
        body = [f"own_{f} = {self._row('DIR', self.writer.plant.parameters.index(q))}" for f, q in enumerate(own) if n]
        body += [f"{self._row('OWN', i)} = " + " + ".join(self._own_parts(i)) for i in range(n) if own]
        doc = "What the filter's own parameters add to its states over a step, for the lanes of the group at g."
        return self._group_function("force_filter", "w_, g", doc, self._own_loads(), body or ["pass"])

    def _own_parts(self, i: int) -> list[str]:
        return [f"d_{f}_{i} * own_{f}" for f in range(len(filter_parameters(self.writer.plant)))]

    def _own_loads(self) -> list[str]:
        own, n = filter_parameters(self.writer.plant), self.layout.filter_states
        return [f"d_{f}_{i} = {self.writer.at.dz[f * n + i]}" for f in range(len(own)) for i in range(n)]

    def _filter_loads(self, *, own: bool) -> list[str]:
        n = self.layout.filter_states
        width = n + 3 * self.layout.fed
        lines = [f"p_{i}_{j} = {self.writer.at.prop[i * width + j]}" for i in range(n) for j in range(width)]
        return lines + (self._own_loads() if own else [])

    def _filter_lines(self, inputs: list[str], *, forced: bool) -> list[str]:
        """Return S_z' = Phi S_z + Gamma S_v, plus the effect of the filter's own parameters on Phi and Gamma."""
        own, n, order = filter_parameters(self.writer.plant), self.layout.filter_states, self.writer.plant.parameters
        body = [f"z_{i} = {self._row('SZ', i)}" for i in range(n)]
        if not forced:
            body += [f"own_{f} = {self._row('DIR', order.index(q))}" for f, q in enumerate(own) if n]
        columns = [*(f"z_{i}" for i in range(n)), *inputs]
        for i in range(n):
            parts = [f"p_{i}_{j} * {column}" for j, column in enumerate(columns) if column != "0.0"]
            parts = [*_in_halves([self._row("OWN", i), *parts])] if forced else [*parts, *self._own_parts(i)]
            body.append(f"n_{i} = " + " + ".join(parts))
        return body + [f"{self._row('SZ', i)} = n_{i}" for i in range(n)]

    def _measure_group(self) -> str:
        """Write dy/dp of a group's lanes, output by output."""
        plant, program, at = self.writer.plant, self.writer.program, self.writer.at
        every = (*plant.states, *plant.filter.states)
        before, body = [], []
        for j, node in enumerate(program.output_nodes):
            before += [f"y_x_{j}_{i} = {at.y_x[j * len(every) + i]}" for i, s in enumerate(every) if s in node.inner]
            before += [
                f"y_p_{j}_{k} = {at.y_p[j * len(plant.parameters) + k]}"
                for k, q in enumerate(plant.parameters)
                if q in node.outer
            ]
            parts = [f"y_x_{j}_{i} * {self._row('S', i)}" for i, s in enumerate(every) if s in node.inner]
            parts += [f"y_p_{j}_{k} * {self._row('DIR', k)}" for k, q in enumerate(plant.parameters) if q in node.outer]
            body.append(f"{self._row('Y', j)} = " + (" + ".join(parts) or "0.0"))
        # J_ may overlap w_ for all that the compiler knows, so a loop that wrote to it would not become vector code.
        after = [
            f"copy_four(J_, to + {j} * NL + {k}, w_, g + {(self.layout.rows['Y'] + j) * WIDTH + k})"
            for j in range(self.layout.outputs)
            for k in range(0, WIDTH, 4)
        ]
        doc = "dy/dp of the lanes of the group at g, by the gradients of the outputs; output by output from J[to] on."
        lines = ["in_vectors()", *before, f"for l in range({WIDTH}):", *(f"    {line}" for line in body), *after]
        return function("measure_group", "w_, g, J_, to", doc, lines, inline=False)


def _in_halves(parts: list[str]) -> list[str]:
    """Return terms of a sum as the sums of its two halves, which a processor adds side by side."""
    if len(parts) < 4:
        return parts
    middle = (len(parts) + 1) // 2
    return [f"({' + '.join(half)})" for half in (parts[:middle], parts[middle:])]
