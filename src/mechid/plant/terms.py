"""Named terms of a plant: put in an order in which each needs only earlier ones, and written out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp


def in_order(terms: Sequence[tuple[sp.Symbol, sp.Expr]]) -> tuple[tuple[sp.Symbol, sp.Expr], ...]:
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


def expanded(expr: sp.Expr, terms: Sequence[tuple[sp.Symbol, sp.Expr]]) -> sp.Expr:
    """Return an expression with all terms written out."""
    for symbol, definition in reversed(terms):
        expr = expr.subs(symbol, definition)
    return expr


def at_start(
    given: Sequence[sp.Expr], states: Sequence[sp.Symbol], terms: Sequence[tuple[sp.Symbol, sp.Expr]]
) -> tuple[sp.Expr, ...]:
    """Return the states at the start as functions of parameters, inputs and `START_ANGLE` alone.

    What is settled at the start, as a current at a measured voltage, may be given by another state: by its own start.
    """
    whole = [expanded(e, terms) for e in given]
    return tuple(e.xreplace(dict(zip(states, whole, strict=True))) for e in whole)
