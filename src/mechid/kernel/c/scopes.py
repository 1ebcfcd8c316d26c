"""Scopes of a function's local names in C: the innermost blocks that need them."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence

Block = tuple[int, ...]
"""Path to a block: for each enclosing statement its index, and 0 for its body or 1 for its else branch."""


def homes_of(node: ast.FunctionDef) -> dict[str, set[Block]]:
    """Return the blocks in which each name is declared.

    A name that several blocks use independently, since each of them first assigns it, is declared in each.
    """
    uses: dict[str, list[tuple[Block, bool]]] = {}
    body = node.body[1:] if ast.get_docstring(node) else node.body
    for name, block, gives in _uses(body, ()):
        uses.setdefault(name, []).append((block, gives))
    return {name: set(_homes(found, 0)) for name, found in uses.items()}


def _homes(uses: Sequence[tuple[Block, bool]], depth: int) -> Iterator[Block]:
    """Yield the scopes of one name, all of whose uses lie in one block at level `depth`."""
    here = uses[0][0][:depth]
    if any(len(block) == depth for block, _ in uses):
        yield here
        return
    inner: dict[Block, list[tuple[Block, bool]]] = {}
    for block, gives in uses:
        inner.setdefault(block[: depth + 2], []).append((block, gives))
    if len(inner) == 1 or all(_begins_with_a_value(found, depth + 2) for found in inner.values()):
        for found in inner.values():
            yield from _homes(found, depth + 2)
    else:
        yield here


def _begins_with_a_value(uses: Sequence[tuple[Block, bool]], depth: int) -> bool:
    """Return whether the first use in a block, in textual order, is an assignment in that very block."""
    block, gives = uses[0]
    return gives and len(block) == depth


def _uses(statements: Sequence[ast.stmt], block: Block) -> Iterator[tuple[str, Block, bool]]:
    """Yield (name, block, whether it is assigned) in the order of evaluation."""
    for k, statement in enumerate(statements):
        own = [
            n
            for field, value in ast.iter_fields(statement)
            if field not in ("body", "orelse")
            for part in (value if isinstance(value, list) else [value])
            if isinstance(part, ast.AST)
            for n in ast.walk(part)
            if isinstance(n, ast.Name)
        ]
        plain = isinstance(statement, ast.Assign)
        # The right-hand side is evaluated before its target is assigned.
        for n in sorted(own, key=lambda n: isinstance(n.ctx, ast.Store)):
            yield n.id, block, plain and isinstance(n.ctx, ast.Store)
        for number, part in enumerate(("body", "orelse")):
            yield from _uses(getattr(statement, part, []), (*block, k, number))


def names_stored(node: ast.stmt) -> list[str]:
    """Return the names that a statement or a nested one assigns, without loop counters."""
    loops = {n.target.id for n in ast.walk(node) if isinstance(n, ast.For) and isinstance(n.target, ast.Name)}
    names = [n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
    return [name for name in dict.fromkeys(names) if name not in loops]


def assigns_directly(node: ast.stmt, name: str) -> bool:
    """Return whether a statement itself, not a nested one, assigns a name."""
    if not isinstance(node, ast.Assign):
        return False
    target = node.targets[0]
    targets = target.elts if isinstance(target, ast.Tuple) else [target]
    return any(isinstance(t, ast.Name) and t.id == name for t in targets)
