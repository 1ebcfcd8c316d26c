"""Elements of Markdown: escaped cells, tables and lists."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

Row = Sequence[str]


class Strong(str):
    """Emphasised text of a cell."""

    __slots__ = ()


def cell(text: str) -> str:
    r"""Escape a text so that it stays within its cell or line and is not interpreted as markup.

    Examples
    --------
    >>> print(cell("a|b <script> coil_a*"), cell(Strong("2.7")))
    a\|b \<script> coil\_a\* **2.7**
    """
    escaped = "".join(f"\\{c}" if c in "\\|<`*_[]" else c for c in str(text))
    line = " ".join(escaped.split())
    return f"**{line}**" if isinstance(text, Strong) else line


def table(header: Sequence[str], rows: Iterable[Row]) -> str:
    """Return a table with escaped cells."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(t if t == "---" else cell(t) for t in line) + " |" for line in lines)


def bullets(lines: Iterable[str]) -> str:
    """Return a bullet list."""
    return "\n".join(f"- {cell(line)}" for line in lines)
