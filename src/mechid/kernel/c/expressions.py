"""Expressions of a kernel in C99."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from mechid.kernel.c.types import INT, Signature, type_of

_WORDS = """
    auto break case char const continue default do double else enum extern float for goto if inline int long register
    restrict return short signed sizeof static struct switch typedef union unsigned void volatile while main mechanism
    NAN INFINITY
"""
KEYWORDS = frozenset(_WORDS.split())
"""Words that are not available as names of a plant in C."""
SINGLE = re.compile(r"(AT_[A-Z_]+)_(\d+)")
"""Name of a fixed position in a part of the workspace."""
BINARY = {
    ast.Add: ("+", 5),
    ast.Sub: ("-", 5),
    ast.Mult: ("*", 6),
    ast.Div: ("/", 6),
    ast.FloorDiv: ("/", 6),
    ast.Mod: ("%", 6),
    ast.BitAnd: ("&", 3),
}
COMPARED = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
OWN = {
    "abs": "magnitude",
    "min": "smaller",
    "max": "larger",
    "floor": "floor_of",
    "ceil": "ceiling_of",
    "sqrt": "square_root",
    "sin": "sine_of",
    "cos": "cosine_of",
}
"""Functions defined in the C text itself, by their names in Python; integer versions end in ``_int``."""


class Expressions:
    """Prints the expressions of one function."""

    def __init__(self, types: Mapping[str, str], known: Mapping[str, Signature], constants: Mapping[str, Any]) -> None:
        self.types, self.known, self.constants = types, known, constants

    def text(self, node: ast.expr) -> str:
        """Return the text of an expression."""
        return self._text(node)[0]

    def call(self, node: ast.Call, outs: Sequence[str]) -> str:
        """Return the call of a kernel function; `outs` are the destinations of several results."""
        assert isinstance(node.func, ast.Name)
        own = self.known[node.func.id]
        arguments = []
        for name, argument in zip(own.arguments, node.args, strict=True):
            arguments.append(self.text(argument))
            if name in own.counted:
                arguments.append(f"{self.text(argument)}_count")
        return f"{node.func.id}({', '.join([*arguments, *outs])})"

    def _text(self, node: ast.expr) -> tuple[str, int]:
        """Return the text of an expression and its precedence."""
        match node:
            case ast.Constant(value=bool() as value):
                return str(int(value)), 9
            case ast.Constant(value=value):
                return repr(value), 9
            case ast.Name(id=name):
                if place := SINGLE.fullmatch(name):
                    return f"{place[1]} + {place[2]}", 5
                # A plant may name a symbol like a word of C.
                return (f"{name}_" if name in KEYWORDS else name), 9
            case ast.Subscript():
                return self._place(node), 9
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return f"-{self.within(operand, 7)}", 7
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return f"!{self.within(operand, 8)}", 7
            case ast.BinOp():
                return self._binary(node)
            case ast.Compare():
                return self._comparison(node)
            case ast.BoolOp(op=op, values=values):
                sign = " && " if isinstance(op, ast.And) else " || "
                return sign.join(self.within(v, 3) for v in values), 1
            case ast.IfExp(test=test, body=body, orelse=orelse):
                return f"{self.within(test, 2)} ? {self.within(body, 2)} : {self.within(orelse, 2)}", 0
            case ast.Call():
                return self._call(node), 9
            case ast.Attribute(value=ast.Name(id="np"), attr="nan"):
                return "NAN", 9
            case ast.Attribute(value=ast.Name(id="math"), attr=name):
                return repr(getattr(math, name)), 9
            case _:
                raise NotImplementedError(ast.dump(node))

    def within(self, node: ast.expr, least: int) -> str:
        """Return the text of an expression, in parentheses if it binds less tightly than its surroundings."""
        text, tight = self._text(node)
        return text if tight >= least else f"({text})"

    def _binary(self, node: ast.BinOp) -> tuple[str, int]:
        if isinstance(node.op, ast.Pow):
            return f"pow({self.text(node.left)}, {self.text(node.right)})", 9
        sign, tight = BINARY[type(node.op)]
        # Bitwise operands are always parenthesised: in C, & binds less tightly than a comparison.
        least = 9 if sign == "&" else tight
        left, right = self.within(node.left, least), self.within(node.right, max(least, tight + 1))
        return f"{left} {sign} {right}", tight

    def _comparison(self, node: ast.Compare) -> tuple[str, int]:
        left = [node.left, *node.comparators[:-1]]
        parts = [
            f"{self.within(a, 5)} {COMPARED[type(op)]} {self.within(b, 5)}"
            for a, op, b in zip(left, node.ops, node.comparators, strict=True)
        ]
        return (parts[0], 3) if len(parts) == 1 else (" && ".join(parts), 1)

    def _place(self, node: ast.Subscript) -> str:
        # The attribute is a shape, as in x.shape[0].
        if isinstance(node.value, ast.Attribute):
            return f"{self.text(node.value.value)}_count"
        places = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        return self.text(node.value) + "".join(f"[{self.text(place)}]" for place in places)

    def _call(self, node: ast.Call) -> str:
        match node.func:
            case ast.Name(id="int"):
                return self._whole(node.args[0])
            case ast.Name(id=name) if name in self.known:
                return self.call(node, ())
            case ast.Name(id=name) | ast.Attribute(attr=name):
                return self._of_library(name, node.args)
        raise NotImplementedError(ast.dump(node))

    def _whole(self, argument: ast.expr) -> str:
        return self.text(argument) if self._type(argument) == INT else f"(int){self.within(argument, 9)}"

    def _of_library(self, name: str, arguments: Sequence[ast.expr]) -> str:
        """Return the call of a numeric function, defined in the text itself or in the C library."""
        whole = {self._type(a) for a in arguments} == {INT}
        called = OWN.get(name, name) + ("_int" if whole and name in OWN else "")
        texts = [self.text(a) for a in arguments]
        folded = texts[0]
        if name in ("min", "max"):
            for text in texts[1:]:
                folded = f"{called}({folded}, {text})"
            return folded
        return f"{called}({', '.join(texts)})"

    def _type(self, node: ast.expr) -> str:
        return type_of(node, self.types, self.known, self.constants)
