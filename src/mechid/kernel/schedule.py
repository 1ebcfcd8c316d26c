"""Straight-line Python in which no operation waits for a number longer than it must.

A step of the plant is one long chain of dependent operations, and a processor's time goes by the chain's length, not
by the number of operations. So sums and products take first what is known first: each sum joins the two terms that
are ready earliest, again and again (Huffman's construction, which gives the least depth).
"""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterable, Iterator
from itertools import count

import sympy as sp

from mechid.kernel.expressions import Printer

EARLY = -9
"""When a number that does not change over a step is known, in operations before the states are."""


def scheduled(assignments: Iterable[tuple[str, sp.Expr]], early: Collection[sp.Symbol]) -> Iterator[tuple[str, str]]:
    """Yield (name, text) of assignments in order; `early` are the symbols that do not change over a step."""
    printer = _Scheduler(early)
    for name, expr in assignments:
        text, ready = printer.timed(expr)
        printer.ready[sp.Symbol(name)] = ready
        yield name, text[1:-1] if isinstance(expr, sp.Add) and text[0] == "(" else text


class _Scheduler:
    """Knows when each symbol is ready, and prints expressions with that in mind."""

    def __init__(self, early: Collection[sp.Symbol]) -> None:
        self.ready: dict[sp.Symbol, int] = dict.fromkeys(early, EARLY)
        self.printer = Printer({"fully_qualified_modules": True})

    def timed(self, expr: sp.Expr) -> tuple[str, int]:
        """Return an expression's text, and when it is ready."""
        if isinstance(expr, sp.Add):
            return self._sum(expr)
        if isinstance(expr, sp.Mul) and all(f.as_base_exp()[1].is_nonnegative for f in expr.args):
            return self._product(expr)
        symbols = expr.free_symbols
        wait = 1 if expr.args else 0
        return str(self.printer.doprint(expr)), max((self.ready.get(s, 0) for s in symbols), default=EARLY) + wait

    def _sum(self, expr: sp.Add) -> tuple[str, int]:
        """Join the two terms that are ready first until one is left; of two signs the positive one leads."""
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
        """Return when a term is ready, its place among its like, whether it is taken off, and its text."""
        negative = bool(term.as_coeff_Mul()[0] < 0)
        text, ready = self.timed(-term if negative else term)
        return ready, place, negative, text

    def _product(self, expr: sp.Mul) -> tuple[str, int]:
        """Multiply the factors in the order in which they are ready; the last product is one with the sum it is in."""
        number, rest = expr.as_coeff_Mul()
        factors = sorted((self.timed(f)[::-1] for f in sp.Mul.make_args(rest)), key=lambda f: f[0])
        ready = EARLY
        for at, _ in factors:
            ready = max(ready, at) + 1
        texts = [repr(float(abs(number)))] if abs(number) != 1 else []
        return ("-" if number < 0 else "") + "*".join([*texts, *(text for _, text in factors)]), ready - 1
