"""The lanes of a kernel as Python text: the variational equations of all parameters side by side.

Lane l holds dx/dq for one direction q in the space of parameters. All lanes live in one flat workspace
`w`, row by row of `lanes` doubles, so that the innermost loop runs over lanes and the compiler sees every
distance. A parameter's own partial derivative enters every lane by the share that the lane's direction has
of it (rows DIR): so ties and search coordinates cost nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from mechid.kernel.expressions import python_text
from mechid.kernel.physics import Writer, filter_parameters, function
from mechid.kernel.program import Node


@dataclass(frozen=True)
class Layout:
    """Rows of the workspace, counted in lanes."""

    states: int
    filter_states: int
    fed: int
    parameters: int

    @cached_property
    def rows(self) -> dict[str, int]:
        """First row of each part, and the total under ``"END"``."""
        sizes = {
            "S": self.states, "SZ": self.filter_states, "K": self.states, "ACC": self.states,
            "V0": self.fed, "VM": self.fed, "V1": self.fed,
            "DIR": self.parameters, "DTAU": 1,
        }  # fmt: skip
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
        self.nodes: tuple[Node, ...] = (*program.nodes, *(n for n in program.fed if not self._is_shared(n)))
        self.seeded = [n for n in self.nodes if n.outer]
        self.layout = Layout(
            len(program.states),
            len(program.filter_states),
            len(program.filter_inputs),
            len(program.plant.parameters),
        )
        self._coefficients: dict[str, sp.Expr] = {}
        self._slopes = {n.symbol: {v: self._coefficient(n, v, d) for v, d in n.inner.items()} for n in self.nodes}
        self._seeds = {n.symbol: {q: self._coefficient(n, q, d) for q, d in n.outer.items()} for n in self.seeded}

    def functions(self) -> list[str]:
        """Return all lane functions."""
        return [
            self._linearise_of(),
            self._step_lanes(),
            self._evaluate_lanes(),
            self._advance_filter_lanes(),
        ]

    def _is_shared(self, node: Node) -> bool:
        index = int(node.symbol.name.removeprefix("v_"))
        return self.writer.program.filter_inputs[index] in self.writer.program.shared

    def _coefficient(self, node: Node, variable: sp.Symbol, derivative: sp.Expr) -> str:
        """Return the text of a partial derivative; one that changes in time gets a name and a place."""
        ready = self.writer.constants.hoist(self.writer.angles.replace(derivative))
        names = set(self.writer.constants.names.values())
        if ready.free_symbols <= names:
            return python_text(ready)
        name = f"d_{node.symbol}_{variable}"
        self._coefficients[name] = derivative
        return name

    def _constant_loads(self) -> list[str]:
        texts = [t for part in (self._slopes, self._seeds) for row in part.values() for t in row.values()]
        used = [sp.Symbol(t.lstrip("-")) for t in texts]
        return [f"{s} = c[{k}]" for k, s in self.writer.constants.used_in(used)]

    def _results(self, prefix: str) -> str:
        plant, n_fed = self.writer.plant, self.layout.fed
        names = [f"{prefix}_{s}" for s in plant.states] + [f"{prefix}_v{j}" for j in range(n_fed)]
        return ", ".join(names + list(self._coefficients))

    def _linearise_of(self) -> str:
        plant, program = self.writer.plant, self.writer.program
        scalars = (*plant.states, *plant.inputs, *self.writer.mode_symbols)
        wanted = [(f"e_{s}", e) for s, e in zip(plant.states, plant.rates, strict=True)]
        wanted += [(f"e_v{j}", e) for j, e in enumerate(program.filter_inputs)]
        wanted += list(self._coefficients.items())
        lines = [*self.writer.body(wanted, scalars=scalars, share=True), f"return {self._results('e')}"]
        arguments = ", ".join(map(str, scalars))
        return function(
            "linearise_of",
            f"{arguments}, w_",
            "Rates, filter inputs, and the derivatives that change.",
            lines,
            inline=True,
        )

    def _flow_lines(self) -> list[str]:
        """Tangents of all nodes from ``y_<state>``, inside a loop over l."""
        lines = []
        for node in self.nodes:
            parts = [
                _product(text, f"t_{v}" if v in self.writer.program.shared else f"y_{v}")
                for v, text in self._slopes[node.symbol].items()
            ]
            parts += [_product(text, self._direction(q)) for q, text in self._seeds.get(node.symbol, {}).items()]
            lines.append(f"t_{node.symbol} = {' + '.join(parts) or '0.0'}")
        return lines

    def _direction(self, parameter: sp.Symbol) -> str:
        """Return a lane's share of a parameter."""
        return self._row("DIR", self.writer.plant.parameters.index(parameter))

    def _fed_tangent(self, j: int) -> str:
        source = self.writer.program.filter_inputs[j]
        return f"t_{source}" if source in self.writer.program.shared else f"t_v_{j}"

    def _row(self, part: str, index: int) -> str:
        return f"w[{self.layout.rows[part] + index} * NL + l]"

    def _loop(self, displaced: bool, after: list[str]) -> list[str]:
        """One pass over the lanes: ``y_<state>`` from S (displaced by f K), tangents, and what follows."""
        lines = []
        for i, s in enumerate(self.writer.plant.states):
            lines.append(f"y_{s} = {self._row('S', i)}" + (f" + f * {self._row('K', i)}" if displaced else ""))
        lines += self._flow_lines() + after
        return ["for l in range(NL):", *(f"    {line}" for line in lines)]

    def _step_lanes(self) -> str:
        """Write the three inner stages of a step as one loop."""
        states, n_fed = self.writer.plant.states, self.layout.fed
        at = ", ".join([f"{s} + f * k_{s}" for s in states] + self.writer.held_arguments)
        results = ", ".join([f"k_{s}" for s in states] + [f"v_{j}" for j in range(n_fed)] + list(self._coefficients))
        after = []
        for i, s in enumerate(states):
            after += [f"{self._row('K', i)} = t_k_{s}", f"{self._row('ACC', i)} += weight * t_k_{s}"]
        after += [f"{self._row('VM', j)} = share * {self._row('VM', j)} + half_share * {self._fed_tangent(j)}"
                  for j in range(n_fed)]  # fmt: skip
        body = [
            "f = h if stage == 2 else 0.5 * h",
            "weight = 1.0 if stage == 2 else 2.0",
            "share = 1.0 if stage > 0 else 0.0",
            "half_share = 0.25 if stage == 2 else 0.5",
            f"{results} = linearise_of({at}, w_)",
            *self._loop(True, after),
            *(f"acc_{s} += weight * k_{s}" for s in states),
            *(f"mid_{j} += half_share * v_{j}" for j in range(n_fed)),
        ]
        lines = [f"{s} = x[{i}]" for i, s in enumerate(states)]
        lines += [f"k_{s} = k[{i}]" for i, s in enumerate(states)]
        lines += [f"acc_{s} = k_{s}" for s in states] + [f"mid_{j} = 0.0" for j in range(n_fed)]
        lines += [*self._constant_loads(), "for stage in range(3):", *(f"    {line}" for line in body)]
        lines += [f"new[{i}] = {s} + h / 6.0 * acc_{s}" for i, s in enumerate(states)]
        lines += [f"mid[{j}] = mid_{j}" for j in range(n_fed)]
        doc = "As `step`; the lanes' weighted rates into ACC, their filter inputs half way into VM. Consumes K."
        return function("step_lanes", "w_, x_at, k_at, h, new_at, mid_at", doc, lines)

    def _evaluate_lanes(self) -> str:
        states = self.writer.plant.states
        lines = [*self._constant_loads()]
        lines += [f"{self._results('e')} = linearise_of({self.writer.unpacked}, w_)"]
        after = []
        for i, s in enumerate(states):
            after += [f"{self._row('K', i)} = t_k_{s}", f"{self._row('ACC', i)} = t_k_{s}"]
        after += [f"{self._row('V1', j)} = {self._fed_tangent(j)}" for j in range(self.layout.fed)]
        lines += self._loop(False, after)
        lines += [f"k[{i}] = e_{s}" for i, s in enumerate(states)]
        lines += [f"k[{len(states) + j}] = e_v{j}" for j in range(self.layout.fed)]
        doc = "Rates k and filter inputs at x; those of the lanes into K (and ACC) and V1."
        return function("evaluate_lanes", "w_, x_at, k_at", doc, lines)

    def _advance_filter_lanes(self) -> str:
        """Write S_z' = Phi S_z + Gamma S_v, plus what the filter's own parameters do to Phi and Gamma."""
        own, n, n_fed = filter_parameters(self.writer.plant), self.layout.filter_states, self.layout.fed
        columns = [self._row("SZ", i) for i in range(n)]
        columns += [self._row(part, j) for part in ("V0", "VM", "V1") for j in range(n_fed)]
        width = len(columns)
        lines = [f"p_{i}_{j} = prop[{i * width + j}]" for i in range(n) for j in range(width)]
        lines += [f"d_{f}_{i} = dz[{f * n + i}]" for f in range(len(own)) for i in range(n)]
        body = []
        for i in range(n):
            parts = [f"p_{i}_{j} * {column}" for j, column in enumerate(columns)]
            parts += [f"d_{f}_{i} * {self._direction(q)}" for f, q in enumerate(own)]
            body.append(f"n_{i} = " + " + ".join(parts))
        body += [f"{self._row('SZ', i)} = n_{i}" for i in range(n)]
        lines += ["for l in range(NL):", *(f"    {line}" for line in body)]
        doc = "Filter lanes over one step; dz holds what the filter's own parameters add."
        return function("advance_filter_lanes", "w_, prop_at", doc, lines if n else ["return"])


def _product(factor: str, variable: str) -> str:
    if factor == "1.0":
        return variable
    return f"-{variable}" if factor == "-1.0" else f"{factor} * {variable}"
