"""Wiring of each block's inputs to outputs of other blocks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import sympy as sp

from mechid.plant.block import Block, Guard, Switch


class Links:
    """Wiring of one assembly: replaces each block's input symbols by the outputs they are wired to."""

    def __init__(self, blocks: Sequence[Block], wiring: Mapping[str, str]) -> None:
        self.blocks = {b.name: b for b in blocks}
        if len(self.blocks) < len(blocks):
            raise ValueError(f"two blocks have one name: {sorted(b.name for b in blocks)}")
        inputs = {f"{b.name}.{_plain(s)}": s for b in blocks for s in b.inputs}
        if unknown := set(wiring) - set(inputs):
            raise ValueError(f"wiring of unknown inputs {sorted(unknown)}; known: {sorted(inputs)}")
        # Explicit wiring takes precedence over equal names.
        self.wiring = {key: target for key, s in inputs.items() if (target := wiring.get(key) or self._by_name(s))}
        self.free_inputs = [s for key, s in inputs.items() if key not in self.wiring]

    def _by_name(self, symbol: sp.Symbol) -> str | None:
        """Return the only output with an input's name."""
        name = _plain(symbol)
        found = [f"{b.name}.{name}" for b in self.blocks.values() if name in b.outputs]
        if len(found) > 1:
            raise ValueError(f"{name} is wanted, and given by {' and '.join(found)}: wire it")
        return found[0] if found else None

    def output(self, target: str) -> sp.Expr:
        """Return ``"block.output"`` in the plant's symbols."""
        name, _, key = target.partition(".")
        if name not in self.blocks or key not in self.blocks[name].outputs:
            raise ValueError(f"no output {target!r}")
        block = self.blocks[name]
        return self.resolve(block, block.outputs[key])

    def resolve(self, block: Block, expr: sp.Expr) -> sp.Expr:
        """Return a block's expression with its inputs replaced by the wired outputs."""
        expr = sp.sympify(expr)
        used = [s for s in block.inputs if expr.has(s)]
        keys = {s: f"{block.name}.{_plain(s)}" for s in used}
        wired = {s: self.output(self.wiring[key]) for s, key in keys.items() if key in self.wiring}
        # All inputs are replaced at once: one may be wired to an output that contains another's symbol.
        return expr.xreplace(wired)

    def switch(self, block: Block) -> Switch:
        """Return a block's switch with its inputs replaced."""
        switch = block.switch
        assert switch is not None

        def resolve_guard(guard: Guard) -> Guard:
            return Guard(margin=self.resolve(block, guard.margin), target=guard.target, resets=guard.resets)

        return replace(
            switch,
            guards={mode: tuple(map(resolve_guard, guards)) for mode, guards in switch.guards.items()},
            entry=tuple((self.resolve(block, e), mode) for e, mode in switch.entry),
        )


def _plain(symbol: sp.Symbol) -> str:
    return str(symbol.name).removesuffix("_in")
