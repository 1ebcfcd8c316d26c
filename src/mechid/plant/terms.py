"""Ordering, substitution and text of the named terms of a plant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp

from mechid.plant.block import Guard


def sort_terms(terms: Sequence[tuple[sp.Symbol, sp.Expr]]) -> tuple[tuple[sp.Symbol, sp.Expr], ...]:
    """Sort terms so that each follows those it contains; a linear loop is solved for its terms."""
    pending = dict(terms)
    known: dict[sp.Symbol, sp.Expr] = {}
    while pending:
        ready = [s for s, e in pending.items() if not e.free_symbols & pending.keys()]
        if not ready:
            # The remaining terms need each other: an algebraic loop.
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


def expand_terms(expr: sp.Expr, terms: Sequence[tuple[sp.Symbol, sp.Expr]]) -> sp.Expr:
    """Return an expression with all terms substituted."""
    held = expr.free_symbols
    for symbol, definition in reversed(terms):
        if symbol in held:
            expr = expr.subs(symbol, definition)
            held = expr.free_symbols
    return expr


def start_states(
    given: Sequence[sp.Expr], states: Sequence[sp.Symbol], terms: Sequence[tuple[sp.Symbol, sp.Expr]]
) -> tuple[sp.Expr, ...]:
    """Return the initial states as functions of parameters, inputs and `START_ANGLE` alone.

    A settled quantity, such as a current at a measured voltage, may be given by another state: that state's start is
    used.
    """
    whole = [expand_terms(e, terms) for e in given]
    return tuple(e.xreplace(dict(zip(states, whole, strict=True))) for e in whole)


def structure_text(value: object) -> str:
    """Return a text that is the same in every process for the same symbolic value."""
    if isinstance(value, Guard):
        return f"guard({structure_text(value.margin)},{value.target},{structure_text(value.resets)})"
    if isinstance(value, Mapping):
        return "{" + ",".join(f"{structure_text(k)}:{structure_text(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "(" + ",".join(map(structure_text, value)) + ")"
    # srepr spells out a symbol's assumptions and an expression's structure, which str does not.
    return sp.srepr(value) if isinstance(value, sp.Basic | sp.MatrixBase) else repr(value)
