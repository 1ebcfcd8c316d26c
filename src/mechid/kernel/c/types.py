"""C types of a kernel's functions and of their local names."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

INT, DOUBLE, NUMBERS, INTEGERS = "int", "double", "double *", "int *"
ANNOTATIONS = {
    "int": INT,
    "bool": INT,
    "float": DOUBLE,
    "Numbers": NUMBERS,
    "Array": NUMBERS,
    "Integers": INTEGERS,
    "IntegerArray": INTEGERS,
}


@dataclass(frozen=True)
class Signature:
    """Arguments and results of a function.

    Attributes
    ----------
    arguments : mapping of str to str
        Types by name.
    written : frozenset of str
        Arrays that the function or its callees may write to.
    counted : frozenset of str
        Arrays whose length is read.
    returns : tuple of str
        Types of the results; a single one is returned, several are written through pointers.
    """

    arguments: Mapping[str, str]
    written: frozenset[str]
    counted: frozenset[str]
    returns: tuple[str, ...]


def signatures(functions: Mapping[str, ast.FunctionDef]) -> dict[str, Signature]:
    """Return the signature of each function."""
    written = {name: _written_arrays(node) for name, node in functions.items()}
    # An array that a callee writes to is written by its caller too: propagate until nothing changes.
    before = None
    while before != (now := {name: frozenset(found) for name, found in written.items()}):
        before = now
        for name, node in functions.items():
            for callee, place, array in _passed_arrays(node, functions):
                if functions[callee].args.args[place].arg in written[callee]:
                    written[name].add(array)
    return {
        name: Signature(
            {a.arg: ANNOTATIONS[ast.unparse(a.annotation)] for a in node.args.args if a.annotation},
            frozenset(written[name]),
            frozenset(_arrays_with_length(node)),
            _result_types(node),
        )
        for name, node in functions.items()
    }


def _written_arrays(node: ast.FunctionDef) -> set[str]:
    """Return the arrays that a function itself writes to."""
    stores = (n for n in ast.walk(node) if isinstance(n, ast.Subscript) and isinstance(n.ctx, ast.Store))
    return {n.value.id for n in stores if isinstance(n.value, ast.Name)}


def _passed_arrays(node: ast.FunctionDef, functions: Mapping[str, ast.FunctionDef]) -> Iterator[tuple[str, int, str]]:
    """Yield (function, argument position, name) of each plain name that is passed on in a call."""
    for call in (n for n in ast.walk(node) if isinstance(n, ast.Call) and isinstance(n.func, ast.Name)):
        if isinstance(call.func, ast.Name) and call.func.id in functions:
            for place, argument in enumerate(call.args):
                if isinstance(argument, ast.Name):
                    yield call.func.id, place, argument.id


def _arrays_with_length(node: ast.FunctionDef) -> Iterator[str]:
    for n in ast.walk(node):
        if isinstance(n, ast.Attribute) and n.attr == "shape" and isinstance(n.value, ast.Name):
            yield n.value.id


def _result_types(node: ast.FunctionDef) -> tuple[str, ...]:
    text = ast.unparse(node.returns) if node.returns else "None"
    if text == "None":
        return ()
    inner = text.removeprefix("tuple[").removesuffix("]").split(", ")
    return tuple(ANNOTATIONS[one] for one in inner)


def names_in(node: ast.FunctionDef, known: Mapping[str, Signature], constants: Mapping[str, Any]) -> dict[str, str]:
    """Return the types of a function's arguments and local names, by their first assignment."""
    types = dict(known[node.name].arguments)

    def of(expr: ast.expr) -> str:
        return type_of(expr, types, known, constants)

    for statement in _in_order(node.body):
        if isinstance(statement, ast.For) and isinstance(statement.target, ast.Name):
            types.setdefault(statement.target.id, INT)
        elif isinstance(statement, ast.Assign):
            for target, kind in _kinds(statement, of, known):
                types.setdefault(target, kind)
    return types


def _kinds(statement: ast.Assign, of: Any, known: Mapping[str, Signature]) -> Iterator[tuple[str, str]]:
    target, value = statement.targets[0], statement.value
    if isinstance(target, ast.Name):
        yield target.id, of(value)
    elif isinstance(target, ast.Tuple):
        if isinstance(value, ast.Tuple):
            kinds = [of(v) for v in value.elts]
        else:
            assert isinstance(value, ast.Call)
            assert isinstance(value.func, ast.Name)
            kinds = list(known[value.func.id].returns)
        yield from ((t.id, kind) for t, kind in zip(target.elts, kinds, strict=True) if isinstance(t, ast.Name))


def _in_order(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    for statement in body:
        yield statement
        for part in ("body", "orelse"):
            yield from _in_order(getattr(statement, part, []))


def type_of(
    expr: ast.expr, types: Mapping[str, str], known: Mapping[str, Signature], constants: Mapping[str, Any]
) -> str:
    """Return the type of an expression, INT or DOUBLE, or of an array's name that of the array."""

    def of(part: ast.expr) -> str:
        return type_of(part, types, known, constants)

    match expr:
        case ast.Constant(value=value):
            return DOUBLE if isinstance(value, float) else INT
        case ast.Name(id=name):
            return types[name] if name in types else _of_value(constants[name])
        case ast.Subscript(value=ast.Name(id=name)):
            return INT if types.get(name) == INTEGERS or name in constants else DOUBLE
        case ast.Subscript():
            # Subscripts of an attribute are lengths of arrays.
            return INT
        case ast.BinOp(left=left, op=op, right=right):
            both = {of(left), of(right)}
            # Python's division of integers gives a float.
            return DOUBLE if DOUBLE in both or isinstance(op, ast.Div | ast.Pow) else INT
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return of(operand)
        case ast.IfExp(body=body, orelse=orelse):
            return DOUBLE if DOUBLE in {of(body), of(orelse)} else INT
        case ast.Call(func=ast.Name(id=name), args=arguments):
            if name in known:
                return known[name].returns[0]
            return INT if name == "int" or {of(a) for a in arguments} == {INT} else DOUBLE
        case ast.Call() | ast.Attribute():
            return DOUBLE
        case _:
            # Comparisons and Boolean operations.
            return INT


def _of_value(value: Any) -> str:
    return DOUBLE if isinstance(value, float) else INT
