"""Which branches of mechid's own code have been taken: its modules are compiled with a mark at the head of each.

A branch is a function's body, a way out of an `if` or a loop, a handler, a case, an operand of `and` and `or`, a
condition within a comprehension. Marks are written into the syntax tree at import, so that libraries run at full speed.
"""

import ast
import builtins
import importlib.abc
import importlib.machinery
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1] / "src" / "mechid"
WATCHED = (
    "records",
    "structure",
    "campaign",
    "command",
    "cli",
    "fleets/fleet_file",
    "fleets/estimates",
    "fleets/members",
    "reading/whole",
    "reading/frames",
    "units",
    "parameter",
    "identification/result",
    "identification/computation/journal",
    "budgets/budget_file",
    "budgets/structure_entry",
    "budgets/requirement_entry",
    "budgets/mode_entry",
    "budgets/error_entry",
    "budgets/flight_entry",
    "checks/data_file",
    "budgets/operating_mode",
    "budgets/requirement",
    "designs/design_file",
    "designs/diagnosis_file",
)
"""What reads inputs; equations, kernels and the search are held by other tests."""
MARK = "__mechid_branch__"

taken: set[str] = set()
"""The branches that this process has taken."""


def watch() -> None:
    """Have the modules that are imported from now on say which branches they take."""
    if not hasattr(builtins, MARK):
        setattr(builtins, MARK, taken.add)
        sys.meta_path.insert(0, _Finder())


def all_branches() -> frozenset[str]:
    """Return every branch that there is in what is watched."""
    return frozenset(name for path in _files() for name in _marked(path)[1])


def _files() -> Iterator[Path]:
    for place in WATCHED:
        yield from sorted((ROOT / place).rglob("*.py")) if (ROOT / place).is_dir() else [ROOT / f"{place}.py"]


def _marked(path: Path) -> tuple[ast.Module, list[str]]:
    """Return a module's tree with marks, and their names."""
    marker = _Marker(path.relative_to(ROOT).with_suffix("").as_posix())
    tree = marker.visit(ast.parse(path.read_text(encoding="utf-8"), str(path)))
    return ast.fix_missing_locations(tree), marker.names


class _Finder(importlib.abc.MetaPathFinder):
    """Gives the modules that are watched with marks, and leaves all others to those behind it."""

    def __init__(self) -> None:
        self.files = frozenset(_files())

    def find_spec(self, name, path=None, target=None):
        """Return the module's place, with a loader of our own where it is watched."""
        if not name.startswith("mechid"):
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path, target)
        if spec is not None and spec.origin and Path(spec.origin) in self.files:
            spec.loader = _Loader(name, spec.origin)
        return spec


class _Loader(importlib.machinery.SourceFileLoader):
    """Compiles a module with marks; nothing is cached."""

    def get_code(self, fullname):
        """Return the compiled module."""
        path = Path(self.path)
        return compile(_marked(path)[0], str(path), "exec", dont_inherit=True)


class _Marker(ast.NodeTransformer):
    """Puts a mark at the head of each branch of functions; what runs at import has none."""

    def __init__(self, module: str) -> None:
        self.module, self.names, self.depth = module, [], 0

    def _call(self, node: ast.AST) -> ast.Call:
        name = f"{self.module}:{node.lineno}.{len(self.names)}"
        self.names.append(name)
        return ast.Call(ast.Name(MARK, ast.Load()), [ast.Constant(name)], [])

    def _block(self, body: list[ast.stmt], at: ast.AST) -> list[ast.stmt]:
        mark = ast.copy_location(ast.Expr(self._call(body[0] if body else at)), at)
        return [mark, *body]

    def _value(self, value: ast.expr) -> ast.expr:
        """Return an expression with a mark that is passed where its value is asked for."""
        return ast.copy_location(ast.BoolOp(ast.Or(), [self._call(value), value]), value)

    def visit_FunctionDef(self, node):
        self.depth += 1
        self.generic_visit(node)
        self.depth -= 1
        documented = ast.get_docstring(node) is not None
        node.body = [*node.body[:documented], *self._block(node.body[documented:], node)]
        return node

    def visit_ClassDef(self, node):
        depth, self.depth = self.depth, 0
        self.generic_visit(node)
        self.depth = depth
        return node

    def generic_visit(self, node):
        super().generic_visit(node)
        if self.depth == 0:
            return node
        if isinstance(node, ast.If | ast.For | ast.While):
            node.body, node.orelse = self._block(node.body, node), self._block(node.orelse, node)
        elif isinstance(node, ast.ExceptHandler | ast.match_case):
            at = node if isinstance(node, ast.ExceptHandler) else node.body[0]
            node.body = self._block(node.body, at)
        elif isinstance(node, ast.BoolOp):
            node.values = [node.values[0], *map(self._value, node.values[1:])]
        elif isinstance(node, ast.IfExp):
            node.body, node.orelse = self._value(node.body), self._value(node.orelse)
        elif isinstance(node, ast.comprehension):
            node.ifs = [self._condition(condition) for condition in node.ifs]
        return node

    def _condition(self, condition: ast.expr) -> ast.expr:
        true, false = (self._value(ast.copy_location(ast.Constant(x), condition)) for x in (True, False))
        return ast.copy_location(ast.IfExp(condition, true, false), condition)
