"""Combination of the linear filters of all blocks into one system behind the plant, in parallel or in series."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from mechid.plant.block import Block, LinearSystem
from mechid.plant.wiring import Links

NO_FILTER = LinearSystem(states=(), inputs=(), A=sp.zeros(0, 0), B=sp.zeros(0, 0))


def combine_filters(links: Links, blocks: Sequence[Block], terms: Sequence[sp.Symbol]) -> LinearSystem:
    """Combine the blocks' filters into one system, in parallel or in series.

    The input of a filter may contain states of other filters, with coefficients in parameters alone; they enter A. The
    remainder is split into the plant's terms, whose coefficients enter B, provided that it is linear in them.
    """
    systems = [(f, [links.resolve(b, u) for u in f.inputs]) for b in blocks if (f := b.filter) is not None]
    if not systems:
        return NO_FILTER
    fixed = {sp.Symbol(d.symbol) for b in blocks for d in b.declarations}
    fixed |= {s for b in blocks for s in b.coordinates}
    states = tuple(s for f, _ in systems for s in f.states)
    A = sp.Matrix(sp.diag(*(f.A for f, _ in systems)))
    columns: dict[sp.Expr, sp.Matrix] = {}
    row = 0
    for f, sources in systems:
        rows = slice(row, row + len(f.states))
        for j, source in enumerate(sources):
            own, rest = _linear_parts(source, states)
            for k, gain in own.items():
                A[rows, states.index(k)] += gain * f.B[:, j]
            for u, gain in _by_term(rest, terms, fixed).items():
                column = columns.setdefault(u, sp.zeros(len(states), 1))
                column[rows, 0] += gain * f.B[:, j]
        row += len(f.states)
    B = sp.Matrix.hstack(*columns.values()) if columns else sp.zeros(len(states), 0)
    return LinearSystem(states=states, inputs=tuple(columns), A=A, B=B)


def _linear_parts(expr: sp.Expr, variables: Sequence[sp.Symbol]) -> tuple[dict[sp.Symbol, sp.Expr], sp.Expr]:
    """Return the coefficients of some variables in an expression that is linear in them, and the remainder."""
    expr = sp.expand(expr) if expr.free_symbols & set(variables) else expr
    found = {v: d for v in variables if (d := sp.diff(expr, v)) != 0}
    rest = expr.subs(dict.fromkeys(found, 0))
    # A coefficient that still contains a state is none of a linear filter.
    if any(d.free_symbols & set(variables) for d in found.values()):
        raise ValueError(f"a filter is fed by {expr}, which is not linear in {list(found)}")
    return found, rest


def _by_term(expr: sp.Expr, terms: Sequence[sp.Symbol], fixed: set[sp.Symbol]) -> dict[sp.Expr, sp.Expr]:
    """Return {term: coefficient} of an expression linear in terms, coefficients of parameters; else {expression: 1}."""
    if expr == 0:
        return {}
    found = {t: sp.diff(expr, t) for t in terms if expr.has(t)}
    whole = sp.expand(expr - sum((t * d for t, d in found.items()), sp.Integer(0))) == 0
    if not found or not whole or any(d.free_symbols - fixed for d in found.values()):
        # An input that is not linear in the terms enters the filter as one expression.
        return {expr: sp.Integer(1)}
    return found
