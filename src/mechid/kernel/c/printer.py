"""Functions of a kernel in C99."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from mechid.kernel.c.expressions import SINGLE, Expressions
from mechid.kernel.c.module import Module
from mechid.kernel.c.scopes import assigns_directly, homes_of, names_stored
from mechid.kernel.c.types import DOUBLE, INT, INTEGERS, NUMBERS, Signature, names_in, signatures

INDENT = "    "
WIDTH = 110
_NAMES = """
    NL NS NEXT_SAMPLE EDGE EVENTS ROWS MODE AT_X AT_U AT_TIME SIZE DISCRETE GRID_START GRID_INTERVAL GRID_STEP
    GRID_CLOSE EVENT_TIME EVENT_SWITCH EVENT_BEFORE EVENT_AFTER EVENT_LANES
"""
NEEDED = frozenset(_NAMES.split())
"""Constants that a caller of the kernel needs."""


class Printer:
    """Prints the functions of a module."""

    def __init__(self, module: Module) -> None:
        self.module = module
        self.known = signatures(module.functions)

    def constants(self) -> str:
        """Return the constants that the functions or a caller use; integers as an enumeration."""
        used = {n.id for node in self.module.functions.values() for n in ast.walk(node) if isinstance(n, ast.Name)}
        used |= {place[1] for name in used if (place := SINGLE.fullmatch(name))}
        whole, others = [], []
        for name, value in self.module.constants.items():
            if name not in used | NEEDED or SINGLE.fullmatch(name):
                continue
            if isinstance(value, int):
                whole.append(f"    {name} = {value}")
            elif isinstance(value, float):
                others.append(f"#define {name} {value!r}")
            else:
                others.append(_table(name, value))
        return "\n".join(["enum {", ",\n".join(whole), "};", "", *others])

    def text(self) -> str:
        """Return all functions, each after its heading."""
        parts = []
        for name, node in self.module.functions.items():
            if name in self.module.headings:
                parts.append(_block_comment(self.module.headings[name]))
            parts.append(_Function(node, self.module, self.known).text())
        return "\n".join(parts)


class _Function:
    """Prints one function."""

    def __init__(self, node: ast.FunctionDef, module: Module, known: Mapping[str, Signature]) -> None:
        self.node, self.module, self.known = node, module, known
        self.types = names_in(node, known, module.constants)
        self.own = known[node.name]
        self.expressions = Expressions(self.types, known, module.constants)
        self.homes = homes_of(node)
        self.declared = set(self.own.arguments)

    def text(self) -> str:
        doc = ast.get_docstring(self.node)
        body = self.node.body[1:] if doc else self.node.body
        lines = [*([_block_comment(doc.splitlines())] if doc else []), f"{self._head()}\n{{"]
        lines += self._body(body, 1, ())
        return "\n".join([*map(wrap_line, lines), "}", ""])

    def _head(self) -> str:
        out = self.own.returns
        arguments = []
        for name, kind in self.own.arguments.items():
            const = "const " if kind in (NUMBERS, INTEGERS) and name not in self.own.written else ""
            arguments.append(f"{const}{kind}{'' if kind.endswith('*') else ' '}{name}")
            if name in self.own.counted:
                arguments.append(f"int {name}_count")
        if len(out) > 1:
            arguments += [f"{kind} *{name}" for kind, name in zip(out, results(self.node), strict=True)]
        returned = out[0] if len(out) == 1 else "void"
        inline = any("forceinline" in ast.unparse(decorator) for decorator in self.node.decorator_list)
        begin = f"static {'inline ' if inline else ''}{returned} {self.node.name}("
        return _wrap_arguments(begin, arguments or ["void"], ")")

    def _body(self, statements: Sequence[ast.stmt], depth: int, block: tuple[int, ...]) -> list[str]:
        before = set(self.declared)
        lines = [
            text for k, statement in enumerate(statements) for text in self._statement(statement, depth, (*block, k))
        ]
        self.declared = before
        return lines

    def _statement(self, node: ast.stmt, depth: int, place: tuple[int, ...]) -> Iterator[str]:
        tab = INDENT * depth
        comment = next((c for line in (node.lineno, node.end_lineno or 0) if (c := self.module.comments.get(line))), "")
        if (comment and not isinstance(node, ast.Assign | ast.AugAssign)) or comment:
            yield f"{tab}/* {comment} */"
        yield from self._declarations(node, tab, place)
        match node:
            case ast.Assign(targets=[target], value=value):
                yield from self._assign(target, value, tab, place)
            case ast.AugAssign(target=target, op=op, value=value):
                yield f"{tab}{self.expressions.text(target)} {_sign(op)}= {self.expressions.text(value)};"
            case ast.Return(value=None):
                if depth > 1 or node is not self.node.body[-1]:
                    yield f"{tab}return;"
            case ast.Return(value=value):
                assert value is not None
                yield from self._return(value, tab)
            case ast.Expr(value=ast.Call() as call):
                yield f"{tab}{self.expressions.text(call)};"
            case ast.For():
                yield from self._for(node, depth, place)
            case ast.While():
                yield f"{tab}for (;;) {{" if ast.unparse(node.test) == "True" else self._while(node, tab)
                yield from self._body(node.body, depth + 1, (*place, 0))
                yield f"{tab}}}"
            case ast.If():
                yield from self._if(node, depth, place)
            case ast.Break():
                yield f"{tab}break;"
            case ast.Continue():
                yield f"{tab}continue;"
            case ast.Pass():
                pass
            case _:
                raise NotImplementedError(ast.dump(node))

    def _while(self, node: ast.While, tab: str) -> str:
        return f"{tab}while ({self.expressions.text(node.test)}) {{"

    def _declarations(self, node: ast.stmt, tab: str, place: tuple[int, ...]) -> Iterator[str]:
        """Yield declarations of names whose scope begins at the block of this statement."""
        for name in names_stored(node):
            if name not in self.declared and place[:-1] in self.homes[name] and not assigns_directly(node, name):
                self.declared.add(name)
                yield f"{tab}{self.types[name]} {name} = {'0' if self.types[name] == INT else '0.0'};"

    def _target(self, target: ast.expr) -> str:
        """Return a target's text, with its type if it is declared here."""
        text = self.expressions.text(target)
        if isinstance(target, ast.Name) and target.id not in self.declared:
            self.declared.add(target.id)
            # const tells a reader of the C text that the value does not change.
            const = "const " if self._is_assigned_once(target.id) else ""
            return f"{const}{self.types[target.id]} {text}"
        return text

    def _is_assigned_once(self, name: str) -> bool:
        """Return whether a name is assigned only once."""
        stores = [
            n for n in ast.walk(self.node) if isinstance(n, ast.Name) and n.id == name and isinstance(n.ctx, ast.Store)
        ]
        return len(stores) == 1

    def _assign(self, target: ast.expr, value: ast.expr, tab: str, place: tuple[int, ...]) -> Iterator[str]:
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            yield from self._assign_many(list(zip(target.elts, value.elts, strict=True)), tab)
        elif isinstance(target, ast.Tuple):
            assert isinstance(value, ast.Call)
            for one in target.elts:
                if isinstance(one, ast.Name) and one.id not in self.declared:
                    self.declared.add(one.id)
                    yield f"{tab}{self.types[one.id]} {self.expressions.text(one)};"
            outs = [f"&{self.expressions.text(one)}" for one in target.elts]
            yield f"{tab}{self.expressions.call(value, outs)};"
        else:
            text = self.expressions.text(value)
            yield f"{tab}{self._target(target)} = {text};"

    def _assign_many(self, pairs: list[tuple[ast.expr, ast.expr]], tab: str) -> Iterator[str]:
        """Yield assignments in sequence, through temporaries if one changes a value that a later one reads."""
        changed: set[str] = set()
        crossing = False
        for target, value in pairs:
            crossing |= bool(
                changed & {ast.unparse(n) for n in ast.walk(value) if isinstance(n, ast.Name | ast.Subscript)}
            )
            changed.add(ast.unparse(target))
        # Python evaluates the whole right-hand side first, C one assignment after the other.
        if crossing:
            kinds = [self.types.get(t.id, DOUBLE) if isinstance(t, ast.Name) else DOUBLE for t, _ in pairs]
            for k, ((_, value), kind) in enumerate(zip(pairs, kinds, strict=True)):
                yield f"{tab}const {kind} next_{k} = {self.expressions.text(value)};"
            yield from (f"{tab}{self._target(target)} = next_{k};" for k, (target, _) in enumerate(pairs))
        else:
            yield from (
                f"{tab}{self._target(target)} = {text};"
                for target, text in [(t, self.expressions.text(v)) for t, v in pairs]
            )

    def _return(self, value: ast.expr, tab: str) -> Iterator[str]:
        if len(self.own.returns) == 1:
            yield f"{tab}return {self.expressions.text(value)};"
            return
        if isinstance(value, ast.IfExp):
            yield f"{tab}if ({self.expressions.text(value.test)}) {{"
            yield from self._results(value.body, tab + INDENT)
            yield f"{tab}}} else {{"
            yield from self._results(value.orelse, tab + INDENT)
            yield f"{tab}}}"
        else:
            yield from self._results(value, tab)
        if len(tab) > len(INDENT):
            yield f"{tab}return;"

    def _results(self, value: ast.expr, tab: str) -> Iterator[str]:
        assert isinstance(value, ast.Tuple)
        for name, one in zip(results(self.node), value.elts, strict=True):
            yield f"{tab}*{name} = {self.expressions.text(one)};"

    def _for(self, node: ast.For, depth: int, place: tuple[int, ...]) -> Iterator[str]:
        tab = INDENT * depth
        assert isinstance(node.iter, ast.Call)
        assert isinstance(node.target, ast.Name)
        bounds = [self.expressions.within(a, 5) for a in node.iter.args]
        first, last = bounds[:2] if len(bounds) > 1 else ("0", bounds[0])
        step = f" += {bounds[2]}" if len(bounds) > 2 else "++"
        name = self.expressions.text(node.target)
        self.declared.add(node.target.id)
        yield f"{tab}for (int {name} = {first}; {name} < {last}; {name}{step}) {{"
        yield from self._body(node.body, depth + 1, (*place, 0))
        self.declared.discard(node.target.id)
        yield f"{tab}}}"

    def _if(self, node: ast.If, depth: int, place: tuple[int, ...], *, begin: str = "if") -> Iterator[str]:
        tab = INDENT * depth
        yield f"{tab}{begin} ({self.expressions.text(node.test)}) {{"
        yield from self._body(node.body, depth + 1, (*place, 0))
        if len(node.orelse) == 1 and isinstance(node.orelse[0], ast.If):
            yield from self._if(node.orelse[0], depth, (*place, 1, 0), begin="} else if")
            return
        if node.orelse:
            yield f"{tab}}} else {{"
            yield from self._body(node.orelse, depth + 1, (*place, 1))
        yield f"{tab}}}"


def _table(name: str, value: Any) -> str:
    """Return a one- or two-dimensional table of integers."""
    rows = value.tolist()
    sizes = "".join(f"[{n}]" for n in value.shape)
    inner = ", ".join(f"{{{', '.join(map(str, row))}}}" if isinstance(row, list) else str(row) for row in rows)
    return wrap_line(f"static const int {name}{sizes} = {{{inner}}};")


def results(node: ast.FunctionDef) -> list[str]:
    """Return the names of the output pointers of a function with several results: the returned names with a suffix."""
    returned = [n.value for n in ast.walk(node) if isinstance(n, ast.Return) and n.value]
    tuples = [n for value in returned for n in ast.walk(value) if isinstance(n, ast.Tuple)]
    for values in tuples:
        if all(isinstance(one, ast.Name) for one in values.elts):
            return [f"{ast.unparse(one)}_out" for one in values.elts]
    return [f"out_{k}" for k in range(len(tuples[0].elts))]


def _sign(op: ast.operator) -> str:
    return {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}[type(op)]


def _wrap_arguments(begin: str, parts: Sequence[str], end: str) -> str:
    """Return a list of arguments, wrapped if it is long."""
    lines, line = [], begin
    for k, part in enumerate(parts):
        piece = part + (", " if k + 1 < len(parts) else end)
        if len(line) + len(piece) > WIDTH:
            lines.append(line.rstrip())
            line = INDENT
        line += piece
    return "\n".join([*lines, line])


def wrap_line(line: str) -> str:
    """Return a line wrapped at spaces if it is long; continuation lines are indented further."""
    out, left = [], line
    tab = INDENT * ((len(line) - len(line.lstrip())) // len(INDENT) + 2)
    while len(left) > WIDTH and "\n" not in left:
        at = left.rfind(" ", len(tab) + 1, WIDTH)
        if at < 0:
            break
        out.append(left[:at])
        left = tab + left[at + 1 :]
    return "\n".join([*out, left])


def _block_comment(lines: Sequence[str]) -> str:
    # A comment's end within the text would end the C comment.
    safe = [re.sub(r"\*/", "* /", line) for line in lines]
    if len(safe) == 1:
        return f"/* {safe[0]} */"
    return "\n".join(["/*", *(f" * {line}".rstrip() for line in safe), " */"])
