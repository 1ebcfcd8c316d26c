"""Where in C the local names of a function are declared: in the innermost blocks that need them."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence

Block = tuple[int, ...]
"""The way to a block: of each statement around it the place among its like, and 0 for its body or 1 for its else."""


def homes_of(node: ast.FunctionDef) -> dict[str, set[Block]]:
    """Return the blocks in which each name is to be declared.

    A name that several blocks use, each for itself, since each begins by giving it a value, is declared in each.
    """
    uses: dict[str, list[tuple[Block, bool]]] = {}
    body = node.body[1:] if ast.get_docstring(node) else node.body
    for name, block, gives in _uses(body, ()):
        uses.setdefault(name, []).append((block, gives))
    return {name: set(_homes(found, 0)) for name, found in uses.items()}


def _homes(uses: Sequence[tuple[Block, bool]], depth: int) -> Iterator[Block]:
    """Yield the homes of one name, all of whose uses lie in one block `depth` deep."""
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
    """Tell whether the first use in a block, in the order of the text, gives the name a value in that very block."""
    block, gives = uses[0]
    return gives and len(block) == depth


def _uses(statements: Sequence[ast.stmt], block: Block) -> Iterator[tuple[str, Block, bool]]:
    """Yield (name, block, whether it is given a value) in the order in which they are evaluated."""
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
        for n in sorted(own, key=lambda n: isinstance(n.ctx, ast.Store)):
            yield n.id, block, plain and isinstance(n.ctx, ast.Store)
        for number, part in enumerate(("body", "orelse")):
            yield from _uses(getattr(statement, part, []), (*block, k, number))


def names_stored(node: ast.stmt) -> list[str]:
    """Return the names that a statement, or one within it, gives a value; not those that a loop counts with."""
    loops = {n.target.id for n in ast.walk(node) if isinstance(n, ast.For) and isinstance(n.target, ast.Name)}
    names = [n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
    return [name for name in dict.fromkeys(names) if name not in loops]


def assigns_plainly(node: ast.stmt, name: str) -> bool:
    """Tell whether a statement itself, not one within it, gives a name its value."""
    if not isinstance(node, ast.Assign):
        return False
    target = node.targets[0]
    targets = target.elts if isinstance(target, ast.Tuple) else [target]
    return any(isinstance(t, ast.Name) and t.id == name for t in targets)
