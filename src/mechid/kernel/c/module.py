"""A kernel's Python text as its parts: constants with their values, functions, comments; what is never used taken out.

Without sensitivities whole branches, loops, functions and arguments are idle. They are found by the text alone: a name
that is known to be 0 is put in, a condition that is known decides its branch, a loop that never turns is left away,
and so is what then nobody calls or reads.
"""

from __future__ import annotations

import ast
import io
import math
import tokenize
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

ENTRIES = ("begin", "run", "of_file", "of_file_slopes")
"""Functions that are called from outside."""


@dataclass(frozen=True, eq=False)
class Module:
    """The parts of a kernel's text.

    Attributes
    ----------
    constants : mapping of str to value
        Integers, numbers and arrays of integers, in the order of the text.
    functions : mapping of str to ast.FunctionDef
        In the order of the text.
    comments : mapping of int to str
        Behind a statement, by line.
    headings : mapping of str to tuple of str
        Lines of the comment that stands before a function, by its name.
    """

    constants: Mapping[str, Any]
    functions: Mapping[str, ast.FunctionDef]
    comments: Mapping[int, str] = field(default_factory=dict)
    headings: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def module_of(text: str) -> Module:
    """Return the parts of a kernel's text."""
    tree = ast.parse(text)
    functions = {node.name: _Bare().visit(node) for node in tree.body if isinstance(node, ast.FunctionDef)}
    behind, alone = _comments(text)
    return Module(_constants(tree), functions, behind, _headings(functions, alone))


class _Bare(ast.NodeTransformer):
    """Leaves away where an array becomes numbers by their places alone: in C it is that already."""

    def visit_Assign(self, node: ast.Assign) -> Any:
        """Keep the pairs of an assignment that are no such thing."""
        target, value = node.targets[0], node.value
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            pairs = [(t, v) for t, v in zip(target.elts, value.elts, strict=True) if not _is_bare(v)]
            return _assignment(pairs, node)
        return node


def _is_bare(value: ast.expr) -> bool:
    return isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id == "numbers"


def _constants(tree: ast.Module) -> dict[str, Any]:
    """Return the values that the text assigns outside its functions."""
    known: dict[str, Any] = {"np": np, "math": math}
    body: list[ast.stmt] = [node for node in tree.body if isinstance(node, ast.Assign)]
    exec(compile(ast.Module(body, []), "kernel", "exec"), known)  # our own text, assignments of numbers alone
    names = [n.id for node in body for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
    values = {name: known[name] for name in names if name in known}
    kinds = int | float | np.generic | np.ndarray
    return {name: _plain(value) for name, value in values.items() if isinstance(value, kinds)}


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _comments(text: str) -> tuple[dict[int, str], dict[int, str]]:
    """Return the comments behind statements and those on lines of their own, each by line."""
    behind: dict[int, str] = {}
    alone: dict[int, str] = {}
    lines = text.splitlines()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            place = alone if lines[token.start[0] - 1].lstrip().startswith("#") else behind
            place[token.start[0]] = token.string.lstrip("# ").rstrip()
    return behind, alone


def _headings(functions: Mapping[str, ast.FunctionDef], alone: Mapping[int, str]) -> dict[str, tuple[str, ...]]:
    """Return the heading before each function that has one: the comment lines since the function before."""
    found, end = {}, 0
    for name, node in functions.items():
        first = min([node.lineno, *(d.lineno for d in node.decorator_list)])
        lines = [alone[k] for k in range(end, first) if k in alone and alone[k].strip("-")]
        if lines:
            found[name] = tuple(lines)
        end = node.end_lineno or first
    return found


def without(module: Module, zero: Iterable[str]) -> Module:
    """Return a module in which names are 0, and nothing that is idle then.

    Parameters
    ----------
    module : Module
    zero : iterable of str
        Arguments.
    """
    folding = _Folding({**module.constants, **dict.fromkeys(zero, 0)})
    functions = {name: _visited(folding, node) for name, node in module.functions.items()}
    before = None
    while before != (text := {name: ast.dump(node) for name, node in functions.items()}):
        before = text
        functions = _used(functions)
        functions = {name: _without_idle_names(node) for name, node in functions.items()}
        functions = _without_idle_arguments(functions)
    headings: dict[str, tuple[str, ...]] = {}
    waiting: tuple[str, ...] = ()
    for name in module.functions:
        waiting = module.headings.get(name, waiting)
        if name in functions and waiting:
            headings[name], waiting = waiting, ()
    return Module(module.constants, functions, module.comments, headings)


def _visited(folding: _Folding, node: ast.FunctionDef) -> ast.FunctionDef:
    done = folding.visit(node)
    assert isinstance(done, ast.FunctionDef)
    return ast.fix_missing_locations(done)


class _Folding(ast.NodeTransformer):
    """Puts in what is known, and leaves away branches and loops that are never entered."""

    def __init__(self, known: Mapping[str, Any]) -> None:
        self.known = known

    def visit_If(self, node: ast.If) -> Any:
        """Keep one branch where the condition is known."""
        self.generic_visit(node)
        value = self._value(node.test)
        if value is None:
            return node if node.body or node.orelse else None
        return node.body if value else node.orelse

    def visit_IfExp(self, node: ast.IfExp) -> Any:
        """Keep one value where the condition is known."""
        self.generic_visit(node)
        value = self._value(node.test)
        return node if value is None else node.body if value else node.orelse

    def visit_For(self, node: ast.For) -> Any:
        """Leave away a loop that never turns, or does nothing."""
        self.generic_visit(node)
        assert isinstance(node.iter, ast.Call)
        last = self._value(node.iter.args[min(1, len(node.iter.args) - 1)])
        first = self._value(node.iter.args[0]) if len(node.iter.args) > 1 else 0
        return None if not node.body or (last is not None and first is not None and last <= first) else node

    def _value(self, node: ast.expr) -> Any:
        """Return the value of an expression of known names, or None."""
        names = {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}
        plain = all(isinstance(self.known.get(name), int | float) for name in names - {"min", "max"})
        if not plain or any(isinstance(n, ast.Subscript | ast.Attribute) for n in ast.walk(node)):
            return None
        return eval(compile(ast.Expression(node), "kernel", "eval"), {"min": min, "max": max, **self.known})


def _used(functions: Mapping[str, ast.FunctionDef]) -> dict[str, ast.FunctionDef]:
    """Return the functions that the entries reach, calls of those that do nothing left away."""
    nothing = {name for name, node in functions.items() if name not in ENTRIES and _does_nothing(node)}
    cleared = {name: _Cleared(nothing).visit(node) for name, node in functions.items()}
    todo, reached = {name for name in ENTRIES if name in cleared}, set[str]()
    while todo:
        reached |= todo
        called = {
            n.func.id
            for name in todo
            for n in ast.walk(cleared[name])
            if isinstance(n, ast.Call) and isinstance(n.func, ast.Name)
        }
        todo = (called & cleared.keys()) - reached
    return {name: node for name, node in cleared.items() if name in reached}


def _does_nothing(node: ast.FunctionDef) -> bool:
    return all((isinstance(s, ast.Expr) and isinstance(s.value, ast.Constant)) or _is_bare_return(s) for s in node.body)


def _is_bare_return(node: ast.stmt) -> bool:
    return isinstance(node, ast.Return) and node.value is None


class _Cleared(ast.NodeTransformer):
    """Leaves away calls of functions that do nothing, and what is empty then."""

    def __init__(self, nothing: set[str]) -> None:
        self.nothing = nothing

    def visit_Expr(self, node: ast.Expr) -> Any:
        """Leave away a call of such a function."""
        call = node.value
        gone = isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id in self.nothing
        return None if gone else node

    def visit_For(self, node: ast.For) -> Any:
        """Leave away a loop that does nothing."""
        self.generic_visit(node)
        return node if node.body else None

    def visit_If(self, node: ast.If) -> Any:
        """Leave away a condition that decides nothing."""
        self.generic_visit(node)
        return node if node.body or node.orelse else None


def _without_idle_names(node: ast.FunctionDef) -> ast.FunctionDef:
    """Return a function without assignments of plain values that nobody reads."""
    read = {n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
    grown = {n.target.id for n in ast.walk(node) if isinstance(n, ast.AugAssign) and isinstance(n.target, ast.Name)}
    done = _Idle(read | grown).visit(node)
    assert isinstance(done, ast.FunctionDef)
    return done


class _Idle(ast.NodeTransformer):
    """Leaves away assignments of names that nobody reads, unless a call stands on their right."""

    def __init__(self, read: set[str]) -> None:
        self.read = read

    def visit_Assign(self, node: ast.Assign) -> Any:
        """Leave away the idle names of an assignment."""
        target, value = node.targets[0], node.value
        if isinstance(target, ast.Name) and target.id not in self.read and not _calls(value):
            return None
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            pairs = [
                (t, v)
                for t, v in zip(target.elts, value.elts, strict=True)
                if not (isinstance(t, ast.Name) and t.id not in self.read and not _calls(v))
            ]
            return _assignment(pairs, node)
        return node


def _calls(node: ast.expr) -> bool:
    return any(isinstance(n, ast.Call) for n in ast.walk(node))


def _assignment(pairs: list[tuple[ast.expr, ast.expr]], like: ast.Assign) -> ast.Assign | None:
    if not pairs:
        return None
    targets, values = zip(*pairs, strict=True)
    one = len(pairs) == 1
    target = targets[0] if one else ast.Tuple(list(targets), ast.Store())
    value = values[0] if one else ast.Tuple(list(values), ast.Load())
    return ast.fix_missing_locations(ast.copy_location(ast.Assign([target], value), like))


def _without_idle_arguments(functions: Mapping[str, ast.FunctionDef]) -> dict[str, ast.FunctionDef]:
    """Return functions without the arguments that they do not read, and calls without them."""
    idle = {}
    for name, node in functions.items():
        read = {n.id for statement in node.body for n in ast.walk(statement) if isinstance(n, ast.Name)}
        idle[name] = {k for k, argument in enumerate(node.args.args) if argument.arg not in read}
        node.args.args = [a for k, a in enumerate(node.args.args) if k not in idle[name]]
    for node in functions.values():
        for call in (n for n in ast.walk(node) if isinstance(n, ast.Call) and isinstance(n.func, ast.Name)):
            if isinstance(call.func, ast.Name) and idle.get(call.func.id):
                call.args = [a for k, a in enumerate(call.args) if k not in idle[call.func.id]]
    return dict(functions)
