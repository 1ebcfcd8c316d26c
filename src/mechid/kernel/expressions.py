"""Conversion of SymPy expressions to straight-line Python: hoisted constants, one sine and cosine per angle."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import sympy as sp
from sympy.printing.pycode import PythonCodePrinter


class Printer(PythonCodePrinter):
    """Prints small integer powers as products, and rationals as floats."""

    def _print_Pow(self, expr: sp.Pow, rational: bool = False) -> str:
        base, exponent = expr.as_base_exp()
        text = self.parenthesize(base, 100)
        if exponent == -1:
            return f"(1.0 / {text})"
        # A call of pow costs far more than a few products.
        if exponent.is_Integer and 2 <= int(exponent) <= 4:
            return "(" + " * ".join([text] * int(exponent)) + ")"
        if exponent.is_Integer and -4 <= int(exponent) <= -2:
            return "(1.0 / (" + " * ".join([text] * -int(exponent)) + "))"
        return str(super()._print_Pow(expr, rational=rational))

    def _print_Rational(self, expr: sp.Rational) -> str:
        return repr(float(expr))

    def _print_Integer(self, expr: sp.Integer) -> str:
        return repr(float(expr))


_PRINTER = Printer({"fully_qualified_modules": True})


def python_text(expr: sp.Expr) -> str:
    """Return the Python text of an expression in float arithmetic (functions as ``math.sin``)."""
    return str(_PRINTER.doprint(expr))


@dataclass
class Constants:
    """Subexpressions that contain only parameters, computed once per call and then read by name.

    `names` maps each expression to its name, in the order of the array that holds the values.
    """

    parameters: frozenset[sp.Symbol]
    names: dict[sp.Expr, sp.Symbol] = field(default_factory=dict)

    def hoist(self, expr: sp.Expr) -> sp.Expr:
        """Replace the largest parameter-only parts of `expr` by named constants."""
        if expr.is_Number:
            return expr
        if expr.free_symbols <= self.parameters:
            return self._constant_for(expr)
        if isinstance(expr, sp.Mul | sp.Add):
            return self._hoist_part(expr)
        return expr.func(*map(self.hoist, expr.args)) if expr.args else expr

    def _hoist_part(self, expr: sp.Expr) -> sp.Expr:
        alone = [a for a in expr.args if a.free_symbols <= self.parameters]
        rest = [self.hoist(a) for a in expr.args if a not in alone]
        part = expr.func(*alone)
        return expr.func(part if part.is_Number else self._constant_for(part), *rest)

    def _constant_for(self, expr: sp.Expr) -> sp.Symbol | sp.Expr:
        # An expression and its negative share one constant.
        if expr.could_extract_minus_sign() and not expr.is_Symbol:
            return -self._constant_for(-expr)
        if expr not in self.names:
            self.names[expr] = sp.Symbol(self._name_of(expr))
        return self.names[expr]

    def _name_of(self, expr: sp.Expr) -> str:
        if expr.is_Symbol:
            return str(expr)
        text = str(expr).replace("**", "").replace("/", "_over_").replace("*", "_")
        # Short expressions keep a readable name in the generated text, others are numbered.
        text = re.sub(r"\W", "", text)
        taken = {str(s) for s in self.names.values()}
        plain = re.fullmatch(r"[A-Za-z_]\w*", text) and len(text) <= 24 and text not in taken
        return text if plain and "+" not in str(expr) else f"const_{len(self.names)}"

    def used_in(self, expressions: Iterable[sp.Expr]) -> list[tuple[int, sp.Symbol]]:
        """Return (position, name) of the constants that occur in `expressions`."""
        seen: set[sp.Basic] = set()
        for e in expressions:
            seen |= e.free_symbols
        return [(k, s) for k, s in enumerate(self.names.values()) if s in seen]


@dataclass
class Angles:
    """Sines and cosines of multiples of a few base angles, each base evaluated once.

    sin(n theta + shift) becomes sin(n theta) cos(shift) + cos(n theta) sin(shift), and sines and cosines of
    n theta follow from those of theta by doubling and addition.
    """

    parameters: frozenset[sp.Symbol]
    bases: list[sp.Expr] = field(default_factory=list)

    def collect(self, expressions: Iterable[sp.Expr]) -> None:
        """Choose the base angles for all sines and cosines in `expressions`."""
        turning = {self._split(a.args[0])[0] for e in expressions for a in e.atoms(sp.sin, sp.cos)}
        turning.discard(sp.Integer(0))
        # The smallest multiples come first, so that larger ones find their base among them.
        for angle in sorted(turning, key=lambda a: (abs(a.as_coeff_Mul()[0]), str(a))):
            if not any(_whole_ratio(angle, base) for base in self.bases):
                self.bases.append(angle)

    def replace(self, expr: sp.Expr) -> sp.Expr:
        """Replace the sines and cosines in `expr` by the symbols of `multiples`."""
        atoms = {a: self._by_symbols(a) for a in expr.atoms(sp.sin, sp.cos) if self._split(a.args[0])[0] != 0}
        return expr.xreplace(atoms)

    def pair(self, k: int) -> tuple[sp.Symbol, sp.Symbol]:
        """Return the symbols of sine and cosine of base angle k."""
        return _pair(k, 1)

    @property
    def pairs(self) -> tuple[sp.Symbol, ...]:
        """Symbols of sine and cosine of every base angle, in order."""
        return tuple(s for k in range(len(self.bases)) for s in self.pair(k))

    def multiples(self, expressions: Sequence[sp.Expr]) -> list[tuple[str, sp.Expr]]:
        """Return assignments (name, expression) of the needed sines and cosines of multiples of the bases."""
        seen = set().union(*(e.free_symbols for e in expressions)) if expressions else set()
        result: list[tuple[str, sp.Expr]] = []
        for k in range(len(self.bases)):
            found = (re.fullmatch(rf"(?:sin|cos)_{k}_(\d+)", str(symbol)) for symbol in seen)
            for n in sorted(_chain(int(one[1]) for one in found if one)):
                if n > 1:
                    result += _multiple(k, n)
        return result

    def _split(self, angle: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
        """Split an angle into the part that depends on the states and the part that does not."""
        parts = sp.Add.make_args(sp.expand(angle))
        fixed = [a for a in parts if a.free_symbols <= self.parameters]
        return sp.Add(*(a for a in parts if a not in fixed)), sp.Add(*fixed)

    def _by_symbols(self, atom: sp.Expr) -> sp.Expr:
        turning, shift = self._split(atom.args[0])
        k, n = next((k, n) for k, base in enumerate(self.bases) if (n := _whole_ratio(turning, base)))
        sine, cosine = _pair(k, abs(n))
        sine = sine if n > 0 else -sine
        if isinstance(atom, sp.sin):
            return sine * sp.cos(shift) + cosine * sp.sin(shift)
        return cosine * sp.cos(shift) - sine * sp.sin(shift)


def _whole_ratio(angle: sp.Expr, base: sp.Expr) -> int:
    ratio = sp.simplify(angle / base)
    return int(ratio) if ratio.is_Integer else 0


def _pair(k: int, n: int) -> tuple[sp.Symbol, sp.Symbol]:
    return sp.Symbol(f"sin_{k}_{n}"), sp.Symbol(f"cos_{k}_{n}")


def _chain(orders: Iterable[int]) -> set[int]:
    """Return all orders that doubling and adding one pass through to reach `orders`."""
    todo, done = set(orders) | {1}, set()
    while todo:
        n = todo.pop()
        done.add(n)
        if n > 1:
            todo |= {n // 2} if n % 2 == 0 else {n - 1}
        todo -= done
    return done


def _multiple(k: int, n: int) -> list[tuple[str, sp.Expr]]:
    (s, c), (s1, c1) = _pair(k, n), _pair(k, 1)
    if n % 2 == 0:
        sh, ch = _pair(k, n // 2)
        # Doubling halves the order, so that a high order takes a logarithmic number of products.
        return [(str(s), 2 * sh * ch), (str(c), 1 - 2 * sh * sh)]
    sp_, cp = _pair(k, n - 1)
    return [(str(s), sp_ * c1 + cp * s1), (str(c), cp * c1 - sp_ * s1)]
