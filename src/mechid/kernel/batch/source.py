"""Source text of a batch, derived from that of its kernel: each number becomes `SETS` adjacent numbers.

A plant-specific function is a straight line of assignments, so one loop over the sets around it suffices; inside the
loop, every position is scaled by the number of sets. The compiler vectorises such a loop.
"""

from __future__ import annotations

import ast
import hashlib
from importlib import resources
from types import ModuleType
from typing import Any

from mechid.kernel.source import text_of_loop

SETS = 8
"""Sets per batch: as many numbers as the widest vector register holds. Sixteen would be a twentieth faster."""
LOOP = ("sines", "memory", "filter", "suspects", "sets", "plan", "advance")
"""Modules common to all plants; the plant's functions follow the first."""
OF_PLANT = ("rates_of", "rates", "step", "turn", "outputs")
BY_MODE = ("margins", "slopes")
WIDE = frozenset(("w_", "y_"))
"""Arrays whose positions count over all sets."""
INLINE = "njit(**INNER, fastmath=FAST, forceinline=True)"
"""With constant positions, no arrays can overlap, and the loop over the sets is vectorised."""
UNUSED = "AT_POINTS"
"""Points of a step's stages, which only sensitivities need."""


def fingerprint(kernel_text: str) -> str:
    """Return the hash that names the batch of a kernel, from the module name and text of the kernel."""
    own = "".join(
        resources.files("mechid.kernel.batch").joinpath(f"{name}.py").read_text(encoding="utf-8")
        for name in ("source", *(f"loop/{name}" for name in LOOP))
    )
    return hashlib.sha256(f"{kernel_text} {own}".encode()).hexdigest()[:24]


def generate(kernel_text: str, kernel: ModuleType) -> str:
    """Return the source of a batch module.

    Parameters
    ----------
    kernel_text : str
        Text of the kernel.
    kernel : module
        Module made from `kernel_text`.
    """
    functions = [node for node in ast.parse(kernel_text).body if isinstance(node, ast.FunctionDef)]
    of_plant = [node for node in functions if node.name in OF_PLANT or node.name.startswith(BY_MODE)]
    modes = _modes(functions)
    head = (
        f'"""Batch of {kernel.__name__}. Made by mechid; do not edit."""\n\nfrom __future__ import annotations\n\n'
        f"from {kernel.__name__} import *\nfrom mechid.kernel.pointers import apart, called, in_vectors, rarely\n\n"
        f"SETS = {SETS}\nMODES = np.array({modes})\nMOST_MODES = {max(modes)}\n"
    )
    first, *others = (text_of_loop("mechid.kernel.batch", name) for name in LOOP)
    written = _unroll("\n\n".join(others), {**vars(kernel), "SETS": SETS, "MODES": modes, "MOST_MODES": max(modes)})
    return "\n\n".join([head, first, *map(_over_sets, of_plant), written])


def _modes(functions: list[ast.FunctionDef]) -> list[int]:
    """Return the number of modes of each switch, as in `set_mode`; at least one number."""
    counts: dict[int, int] = {}
    chosen = next(node for node in functions if node.name == "set_mode")
    for node in chosen.body:
        if isinstance(node, ast.If):
            s, mode = (n.value for n in ast.walk(node.test) if isinstance(n, ast.Constant))
            counts[int(str(s))] = max(counts.get(int(str(s)), 0), int(str(mode)) + 1)
    return [counts[s] for s in sorted(counts)] or [0]


def _over_sets(node: ast.FunctionDef) -> str:
    """Return the text of a function for all sets."""
    doc, body = node.body[:1], [s for s in node.body[1:] if not _is_unused(s)]
    # Called from within a loop over the sets, whose index it takes as an argument.
    if node.name == "rates_of":
        node.args.args.append(ast.arg("l", ast.Name("int")))
        node.body = [*doc, *map(_Wide().visit, body)]
    else:
        # Each set has a step length of its own, which is read from the workspace.
        length = ast.parse("h = w_[LENGTH]").body if node.name == "step" else []
        node.args.args = [a for a in node.args.args if a.arg != "h"]
        node.body = [*doc, *ast.parse("in_vectors()").body, *_wrap_in_loops([*length, *body])]
    node.decorator_list = [ast.parse(INLINE, mode="eval").body]
    return ast.unparse(ast.fix_missing_locations(node))


def _is_unused(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Assign) and UNUSED in ast.unparse(statement.targets[0])


def _wrap_in_loops(body: list[ast.stmt]) -> list[ast.stmt]:
    """Wrap runs of computing statements in loops over the sets; branches and calls stay outside."""
    done: list[ast.stmt] = []
    inside: list[ast.stmt] = []
    # The return closes the last open loop.
    for statement in [*body, ast.Return()]:
        alone = isinstance(statement, ast.If | ast.Return) or _is_call(statement)
        if not alone:
            inside.append(_Wide().visit(statement))
            continue
        if inside:
            done.append(ast.For(ast.Name("l", ast.Store()), ast.parse("range(SETS)", mode="eval").body, inside, []))
            inside = []
        if isinstance(statement, ast.If):
            statement.body = _wrap_in_loops(statement.body)
        done.append(statement)
    return done


def _is_call(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Call)


class _Wide(ast.NodeTransformer):
    """Scales every position by the number of sets, and passes the set to the rates."""

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        """Change a position to that of set l."""
        self.generic_visit(node)
        if isinstance(node.value, ast.Name) and node.value.id in WIDE:
            node.slice = ast.parse(f"({ast.unparse(node.slice)}) * SETS + l", mode="eval").body
        return node

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Pass the set to the rates."""
        self.generic_visit(node)
        if isinstance(node.func, ast.Name) and node.func.id == "rates_of":
            node.args.append(ast.Name("l", ast.Load()))
        return node


def _unroll(text: str, known: dict[str, Any]) -> str:
    """Unroll the loops inside loops over the sets, since only an innermost loop is vectorised."""
    tree = ast.parse(text)
    numbers = dict(known)
    values: list[ast.stmt] = [node for node in tree.body if isinstance(node, ast.Assign)]
    # The text is mechid's own; these are assignments of integers only.
    exec(compile(ast.Module(values, []), "batch", "exec"), numbers)
    return ast.unparse(ast.fix_missing_locations(_Unrolled(numbers).visit(tree)))


class _Unrolled(ast.NodeTransformer):
    """Unrolls loops over switches and modes, and all loops inside a loop over the sets."""

    def __init__(self, known: dict[str, Any]) -> None:
        self.known, self.within = known, False

    def visit_For(self, node: ast.For) -> Any:
        """Unroll a loop, or the loops inside a loop over the sets."""
        assert isinstance(node.target, ast.Name)
        name = node.target.id
        if name == "l":
            before, self.within = self.within, True
            node.body = self._all(node.body) or [ast.Pass()]
            self.within = before
            return node
        names = {n.id for n in ast.walk(node.iter) if isinstance(n, ast.Name)}
        # Loops over switches and modes are unrolled everywhere: their bodies differ by constant positions.
        if not (self.within or name in ("s", "mode")) or not names <= {*self.known, "range"}:
            node.body = self._all(node.body)
            return node
        done: list[ast.stmt] = []
        # The iterator is mechid's own text.
        for value in eval(ast.unparse(node.iter), {**self.known}):
            body = [_Put(name, value).visit(ast.parse(ast.unparse(s)).body[0]) for s in node.body]
            done += self._all(body)
        return done

    def _all(self, body: list[ast.stmt]) -> list[ast.stmt]:
        done: list[ast.stmt] = []
        for statement in body:
            found = self.visit(statement)
            done += found if isinstance(found, list) else [found]
        return done


class _Put(ast.NodeTransformer):
    """Replaces a name by a number."""

    def __init__(self, name: str, value: int) -> None:
        self.name, self.value = name, value

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Replace the name."""
        return ast.Constant(self.value) if node.id == self.name else node
