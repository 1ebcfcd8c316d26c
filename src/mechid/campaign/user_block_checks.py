"""Checks of a user block: names, limits and expressions, before equations are built from it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import sympy as sp

from mechid.campaign.place import Place
from mechid.parameter import Declaration
from mechid.plant.block import Block

TEXTS = ("key", "symbol", "unit", "meaning", "source")
EQUATIONS = {"terms": sp.Symbol, "rates": sp.Symbol, "initial": sp.Symbol, "outputs": str}
"""Parts that map names to expressions, with the type of the names."""
NO_NUMBERS = (sp.nan, sp.zoo, sp.oo, sp.S.NegativeInfinity, sp.I)


def refuse_invalid_parts(block: Block, called: str, place: Place) -> None:
    """Refuse a block with an invalid part; `called` is the file and the name in it.

    Raises
    ------
    InputFileError
        The message gives the part, the value found and the value required.
    """
    for problem in (*_invalid_names(block), *_invalid_declarations(block), *_invalid_equations(block)):
        raise place.error(f"{called}: {problem}")


def _invalid_names(block: Block) -> Iterator[str]:
    for key in ("name", "table"):
        if not isinstance(getattr(block, key), str):
            yield f"{key}: found {_quote(getattr(block, key))}; it has to be a text"
    if not _are_all(block.inputs, sp.Symbol):
        yield f"inputs: found {_quote(block.inputs)}; they have to be a tuple of symbols, (T,) of one"


def _invalid_declarations(block: Block) -> Iterator[str]:
    if not _are_all(block.declarations, Declaration):
        yield f"declarations: found {_quote(block.declarations)}; they have to be a tuple of Declaration, (d,) of one"
        return
    for declared in block.declarations:
        for key in TEXTS:
            if not isinstance(getattr(declared, key), str):
                yield f"Declaration {_quote(declared.key)}: {key}: found {_quote(getattr(declared, key))}, no text"
                return
        for key in ("key", "symbol"):
            if not getattr(declared, key).isidentifier():
                yield f"Declaration {_quote(declared.key)}: {key}: found {_quote(getattr(declared, key))}; write a name"
        limits = declared.lower, declared.upper
        if not all(isinstance(one, int | float) for one in limits) or not limits[0] <= limits[1]:
            yield f"Declaration {_quote(declared.key)}: limits: found {limits}; write two numbers, the smaller first"


def _invalid_equations(block: Block) -> Iterator[str]:
    for part, kind in EQUATIONS.items():
        entries = getattr(block, part)
        if not isinstance(entries, Mapping):
            yield f"{part}: found {_quote(entries)}; it has to be a dict of expressions"
            return
        for key, entry in entries.items():
            if not isinstance(key, kind):
                yield f"{part}: found the key {_quote(key)}; it has to be a {'text' if kind is str else 'symbol'}"
            # bool is a subclass of int, and no expression.
            elif isinstance(entry, bool) or not isinstance(entry, sp.Expr | int | float):
                yield f"{part}[{key}]: found {_quote(entry)}; it has to be an expression"
            elif sp.sympify(entry).has(*NO_NUMBERS):
                yield f"{part}[{key}]: found {_quote(entry)}, which is no number"
    for state in block.rates:
        if state not in block.initial:
            yield f"initial: has no {state}; each state, of which there is a rate, begins somewhere"


def _are_all(parts: object, kind: type) -> bool:
    return isinstance(parts, tuple) and all(isinstance(one, kind) for one in parts)


def _quote(found: Any) -> str:
    return f'"{found[:60]}"' if isinstance(found, str) else str(found)[:60]
