"""Tangent program of a plant: the quantities computed and the partial derivatives between them.

Tangents pass through the plant's named terms where several quantities share one; a term used once is
substituted into its user. The Jacobian thus stays as sparse as the physics.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from mechid.plant.plant import Plant


@dataclass(frozen=True)
class Node:
    """One quantity of the tangent program.

    `inner` holds the partial derivatives with respect to states and earlier shared terms, `outer` those with
    respect to parameters; zeros are left out.
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
        """Inputs of the linear filter, as expressions."""
        return self.plant.filter.inputs

    @cached_property
    def shared_terms(self) -> tuple[sp.Symbol, ...]:
        """Terms that are used by at least two rates, filter inputs or other shared terms."""
        names = [s for s, _ in self.plant.terms]
        users = [e for _, e in self.plant.terms] + list(self.plant.rates) + list(self.filter_inputs)
        return tuple(s for s in names if sum(e.has(s) for e in users) > 1)

    @cached_property
    def nodes(self) -> tuple[Node, ...]:
        """Shared terms, then the rates (named ``k_<state>``), in order of computation."""
        definitions = dict(self.plant.terms)
        terms = [self._node(s, definitions[s], s) for s in self.shared_terms]
        rates = [
            self._node(sp.Symbol(f"k_{s}"), e, None) for s, e in zip(self.plant.states, self.plant.rates, strict=True)
        ]
        return tuple(terms + rates)

    @cached_property
    def filter_nodes(self) -> tuple[Node, ...]:
        """Nodes of the filter inputs; a shared term feeds the filter directly."""
        return tuple(self._node(sp.Symbol(f"v_{k}"), e, None) for k, e in enumerate(self.filter_inputs))

    @cached_property
    def output_nodes(self) -> tuple[Node, ...]:
        """Nodes of the outputs, as functions of states and filter states alone."""
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
        """Return the gradient with respect to the states, all terms substituted."""
        full = self.plant.expand(expr)
        return [sp.diff(full, s) for s in self.states]

    def partial_p(self, expr: sp.Expr) -> list[sp.Expr]:
        """Return the gradient with respect to the kernel's parameters, all terms substituted; zero if not estimable."""
        full, estimable = self.plant.expand(expr), self.plant.estimable
        return [sp.diff(full, s) if s in estimable else sp.Integer(0) for s in self.plant.parameters]

    def substitute_terms(self, expr: sp.Expr) -> sp.Expr:
        """Return an expression with the unshared terms substituted."""
        for term, definition in reversed(self.plant.terms):
            if term not in self.shared_terms:
                expr = expr.subs(term, definition)
        return expr

    def _node(self, symbol: sp.Symbol, expr: sp.Expr, itself: sp.Symbol | None) -> Node:
        expr = self.substitute_terms(expr)
        earlier = self.shared_terms if itself is None else self.shared_terms[: self.shared_terms.index(itself)]
        return self._partials(symbol, expr, (*self.states, *earlier))

    def _partials(self, symbol: sp.Symbol, expr: sp.Expr, variables: tuple[sp.Symbol, ...]) -> Node:
        inner = {v: d for v in variables if (d := sp.diff(expr, v)) != 0}
        outer = {q: d for q in self.plant.estimable if (d := sp.diff(expr, q)) != 0}
        return Node(symbol, inner, outer)
