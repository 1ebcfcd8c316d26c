"""Tables as TOML and JSON hold them: changed at a place that is drawn, written as text, and looked up."""

import copy
import datetime
import json
import math
from collections.abc import Iterator
from typing import Any

from fuzz.draw import Draw

Path_ = tuple[str | int, ...]


def leaves(tree: Any, at: Path_ = ()) -> Iterator[tuple[Path_, Any]]:
    """Yield the place and the value of each entry, tables and lists included."""
    entries = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in entries:
        yield (*at, key), value
        yield from leaves(value, (*at, key))


def changed(draw: Draw, tree: dict[str, Any]) -> dict[str, Any]:
    """Return a tree with none to four changes: values, types, keys, places in lists."""
    tree = copy.deepcopy(tree)
    for _ in range(draw.choice((0, 1, 1, 1, 1, 2, 2, 4))):
        places = list(leaves(tree))
        if not places:
            return tree
        at, value = draw.choice(places)
        holder: Any = tree
        for key in at[:-1]:
            holder = holder[key]
        _change(draw, holder, at[-1], value)
    return tree


def _change(draw: Draw, holder: Any, key: Any, value: Any) -> None:
    how = 0 if draw.chance(0.5) else draw.randrange(12)
    if how <= 3 and not isinstance(value, dict | list):
        holder[key] = _like(draw, value)
    elif how <= 5:
        holder[key] = draw.anything()
    elif how == 6:
        del holder[key]
    elif how == 7 and isinstance(holder, dict):
        holder[draw.text() or "key"] = holder.pop(key)
    elif how == 8 and isinstance(holder, dict):
        holder[draw.choice([*holder, draw.text() or "key"])] = draw.anything()
    elif how == 9 and isinstance(holder, list):
        holder.insert(draw.randint(0, len(holder)), copy.deepcopy(value))
    elif how == 10 and isinstance(value, list):
        draw.shuffle(value)
    else:
        holder[key] = [value] if draw.chance(0.5) else {"value": value}


def _like(draw: Draw, value: Any) -> Any:
    """Return another value of the same type, or near it."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return draw.whole()
    if isinstance(value, float):
        return draw.near(value) if draw.chance(0.5) else draw.number()
    return draw.text()


def toml(tree: dict[str, Any]) -> str:
    """Return a tree as TOML, tables within one another in braces."""
    tables = [key for key, value in tree.items() if _is_tables(value)]
    lines = [f"{_key(key)} = {_value(value)}" for key, value in tree.items() if key not in tables]
    for key in tables:
        for one in tree[key]:
            lines += ["", f"[[{_key(key)}]]", *(f"{_key(k)} = {_value(v)}" for k, v in one.items())]
    return "\n".join(lines) + "\n"


def _is_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(one, dict) for one in value)


def _key(key: str) -> str:
    return key if key.isascii() and key.replace("_", "").isalnum() else json.dumps(key)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else {"inf": "inf", "-inf": "-inf"}.get(repr(value), "nan")
    if isinstance(value, datetime.date | int):
        return str(value)
    if isinstance(value, str):
        return json.dumps(value).replace("\x7f", "\\u007f") if value.isprintable() else _escaped(value)
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + " }"
    return '""'


def _escaped(value: str) -> str:
    return '"' + "".join(c if c.isprintable() and c not in '"\\' else f"\\U{ord(c):08X}" for c in value) + '"'


def damaged(draw: Draw, text: str, p: float = 0.1) -> bytes:
    """Return a text as UTF-8; in a share `p` of the inputs with bytes changed, cut off, or in another encoding."""
    content = bytearray(text.encode("utf-8", "replace"))
    if not draw.chance(p) or not content:
        return bytes(content)
    how = draw.randrange(4)
    if how == 0:
        return bytes(content[: draw.randint(0, len(content))])
    if how == 1:
        return text.encode(draw.choice(("utf-16", "utf-8-sig", "latin-1")), "replace")
    for _ in range(draw.choice((1, 1, 3))):
        at = draw.randrange(len(content))
        content[at : at + draw.randrange(2)] = draw.choice(
            (b"[", b"]", b"{", b"}", b'"', b"'", b"=", b"\0", b"\xff", b"\n", b"9", b"-", b".")
        )
    return bytes(content)


def plain(tree: Any) -> Any:
    """Return a tree as JSON holds it: days as text."""
    if isinstance(tree, dict):
        return {key: plain(value) for key, value in tree.items()}
    if isinstance(tree, list):
        return [plain(value) for value in tree]
    return str(tree) if isinstance(tree, datetime.date) else tree
