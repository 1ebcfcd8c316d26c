"""Which quantities the kernel computes, and by which partial derivatives tangents flow between them.

Tangents go through the plant's named terms where several quantities share one; a term used once is
folded into its user. So the Jacobian stays as sparse as the physics.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from mechid.plant.plant import Plant


@dataclass(frozen=True)
class Node:
    """One quantity of the tangent program.

    `inner` are the partial derivatives to states and earlier shared terms, `outer` those to
    parameters; both hold only what is not zero.
    """

    symbol: sp.Symbol
    inner: dict[sp.Symbol, sp.Expr]
    outer: dict[sp.Symbol, sp.Expr]


@dataclass(frozen=True)
class Program:
    """The tangent program of a plant."""

    plant: Plant

    @cached_property
    def filter_inputs(self) -> tuple[sp.Expr, ...]:
        """What feeds the linear filter, as expressions."""
        return self.plant.filter.inputs

    @cached_property
    def shared(self) -> tuple[sp.Symbol, ...]:
        """Terms that at least two of the rates, filter inputs and other shared terms use."""
        names = [s for s, _ in self.plant.terms]
        users = [e for _, e in self.plant.terms] + list(self.plant.rates) + list(self.filter_inputs)
        return tuple(s for s in names if sum(e.has(s) for e in users) > 1)

    @cached_property
    def nodes(self) -> tuple[Node, ...]:
        """Shared terms, then the rates (named ``k_<state>``), in order of computation."""
        definitions = dict(self.plant.terms)
        terms = [self._node(s, definitions[s], s) for s in self.shared]
        rates = [
            self._node(sp.Symbol(f"k_{s}"), e, None) for s, e in zip(self.plant.states, self.plant.rates, strict=True)
        ]
        return tuple(terms + rates)

    @cached_property
    def fed(self) -> tuple[Node, ...]:
        """Nodes of the filter inputs; a shared term feeds the filter as it is."""
        return tuple(self._node(sp.Symbol(f"v_{k}"), e, None) for k, e in enumerate(self.filter_inputs))

    @cached_property
    def measured(self) -> tuple[Node, ...]:
        """Nodes of the outputs, with everything but states and filter states folded in."""
        return tuple(
            self._partials(sp.Symbol(f"y_{k}"), self.plant.expand(e), (*self.states, *self.filter_states))
            for k, e in enumerate(self.plant.outputs.values())
        )

    @property
    def states(self) -> tuple[sp.Symbol, ...]:
        """States of the nonlinear part."""
        return self.plant.states

    @property
    def filter_states(self) -> tuple[sp.Symbol, ...]:
        """States of the closed-form linear part."""
        return self.plant.filter.states

    def partial_x(self, expr: sp.Expr) -> list[sp.Expr]:
        """Gradient to the states with all terms folded in."""
        full = self.plant.expand(expr)
        return [sp.diff(full, s) for s in self.states]

    def partial_p(self, expr: sp.Expr) -> list[sp.Expr]:
        """Gradient to the kernel's parameters with all terms folded in; zero to those not estimable."""
        full, estimable = self.plant.expand(expr), self.plant.estimable
        return [sp.diff(full, s) if s in estimable else sp.Integer(0) for s in self.plant.parameters]

    def folded(self, expr: sp.Expr) -> sp.Expr:
        """Return an expression with the terms that are not shared written out."""
        for term, definition in reversed(self.plant.terms):
            if term not in self.shared:
                expr = expr.subs(term, definition)
        return expr

    def _node(self, symbol: sp.Symbol, expr: sp.Expr, itself: sp.Symbol | None) -> Node:
        expr = self.folded(expr)
        earlier = self.shared if itself is None else self.shared[: self.shared.index(itself)]
        return self._partials(symbol, expr, (*self.states, *earlier))

    def _partials(self, symbol: sp.Symbol, expr: sp.Expr, variables: tuple[sp.Symbol, ...]) -> Node:
        inner = {v: d for v in variables if (d := sp.diff(expr, v)) != 0}
        outer = {q: d for q in self.plant.estimable if (d := sp.diff(expr, q)) != 0}
        return Node(symbol, inner, outer)
