"""Parts of a Markdown text: cells that stay what they are, tables, lists."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

Row = Sequence[str]


class Strong(str):
    """A text that stands out in its cell."""

    __slots__ = ()


def cell(text: str) -> str:
    r"""Return a text that stays within its cell or line and is not read as markup.

    Examples
    --------
    >>> print(cell("a|b <script> coil_a*"), cell(Strong("2.7")))
    a\|b \<script> coil\_a\* **2.7**
    """
    escaped = "".join(f"\\{c}" if c in "\\|<`*_[]" else c for c in str(text))
    line = " ".join(escaped.split())
    return f"**{line}**" if isinstance(text, Strong) else line


def table(header: Sequence[str], rows: Iterable[Row]) -> str:
    """Return a table; its cells are escaped."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(t if t == "---" else cell(t) for t in line) + " |" for line in lines)


def bullets(lines: Iterable[str]) -> str:
    """Return a list of lines."""
    return "\n".join(f"- {cell(line)}" for line in lines)
