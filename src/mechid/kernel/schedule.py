"""Scheduling of straight-line Python for minimal latency.

A step of the plant is one long chain of dependent operations; a processor's time is set by the length of the chain, not
by the number of operations. Sums and products therefore take first the operands that are ready first: each sum
repeatedly joins the two terms that are ready earliest (Huffman's construction, which minimises the depth).
"""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterable, Iterator
from itertools import count

import sympy as sp

from mechid.kernel.expressions import Printer

EARLY = -9
"""Time at which a number that is constant over a step is ready, in operations relative to the states."""


def schedule(assignments: Iterable[tuple[str, sp.Expr]], early: Collection[sp.Symbol]) -> Iterator[tuple[str, str]]:
    """Yield (name, text) of assignments in order; `early` are the symbols that are constant over a step."""
    printer = _Scheduler(early)
    for name, expr in assignments:
        text, ready = printer.print_timed(expr)
        printer.ready[sp.Symbol(name)] = ready
        # The outer parentheses of a sum are redundant in an assignment.
        yield name, text[1:-1] if isinstance(expr, sp.Add) and text[0] == "(" else text


class _Scheduler:
    """Tracks the time at which each symbol is ready, and prints expressions accordingly."""

    def __init__(self, early: Collection[sp.Symbol]) -> None:
        self.ready: dict[sp.Symbol, int] = dict.fromkeys(early, EARLY)
        self.printer = Printer({"fully_qualified_modules": True})

    def print_timed(self, expr: sp.Expr) -> tuple[str, int]:
        """Return an expression's text and the time at which it is ready."""
        if isinstance(expr, sp.Add):
            return self._sum(expr)
        if isinstance(expr, sp.Mul) and all(f.as_base_exp()[1].is_nonnegative for f in expr.args):
            return self._product(expr)
        symbols = expr.free_symbols
        wait = 1 if expr.args else 0
        return str(self.printer.doprint(expr)), max((self.ready.get(s, 0) for s in symbols), default=EARLY) + wait

    def _sum(self, expr: sp.Add) -> tuple[str, int]:
        """Join the two earliest terms until one is left; of two signs the positive one leads."""
        order = count()
        terms = [self._term(term, next(order)) for term in expr.args]
        heapq.heapify(terms)
        while len(terms) > 1:
            ready, _, negative, text = heapq.heappop(terms)
            later, _, other_negative, other = heapq.heappop(terms)
            if negative and not other_negative:
                text, other = other, text
            sign = "+" if negative == other_negative else "-"
            joined = f"({text} {sign} {other})"
            heapq.heappush(terms, (max(ready, later) + 1, next(order), negative and other_negative, joined))
        ready, _, negative, text = terms[0]
        return f"-{text}" if negative else text, ready

    def _term(self, term: sp.Expr, place: int) -> tuple[int, int, bool, str]:
        """Return the ready time of a term, its rank among equals, whether it is subtracted, and its text."""
        negative = bool(term.as_coeff_Mul()[0] < 0)
        text, ready = self.print_timed(-term if negative else term)
        return ready, place, negative, text

    def _product(self, expr: sp.Mul) -> tuple[str, int]:
        """Multiply the factors in the order in which they are ready; the last product fuses with its sum."""
        number, rest = expr.as_coeff_Mul()
        # The factor that is ready last comes last, so that the chain waits for it alone.
        factors = sorted((self.print_timed(f)[::-1] for f in sp.Mul.make_args(rest)), key=lambda f: f[0])
        ready = EARLY
        for at, _ in factors:
            ready = max(ready, at) + 1
        texts = [repr(float(abs(number)))] if abs(number) != 1 else []
        return ("-" if number < 0 else "") + "*".join([*texts, *(text for _, text in factors)]), ready - 1
