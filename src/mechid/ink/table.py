"""Table of a report: one definition of columns, printed on a terminal, in Markdown and on a page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup
from rich.console import Console

from mechid.ink.markdown_text import Strong
from mechid.ink.markdown_text import table as markdown_table
from mechid.ink.text_table import MARKDOWN, PAGE, TERMINAL, Column, Row, cell_of, print_tables

GROUP = "table"
"""Key of the group to which a row belongs."""
# A higher opacity would make the number illegible.
DARKEST = 0.75
"""Largest opacity of a cell's colour."""


@dataclass(frozen=True)
class Table:
    """Columns, and rows with a text for each column.

    Parameters
    ----------
    columns : sequence of Column
    rows : sequence of mapping
        A cell is ``row["text"][key]``, else ``row[key]``. Rows with a ``table`` are grouped under that name, in
        documents according to `group`.
    group : str or None
        Header of the group names if these have their own column, as in Markdown; empty for no such column.
    narrower : sequence of layouts
        Alternatives for narrow terminals, of which the first that fits is used: each one or more tables of the rows.
    tip : str
        Key of the tooltip of a row.
    style : str
        CSS class on a page; rows of ``cards`` are stacked on small pages.

    Examples
    --------
    >>> one = Table(
    ...     (Column("stage", "name", words=True), Column("took s", "s", said="took, s")),
    ...     [{"name": "joint fit", "text": {"s": "1.5"}}],
    ... )
    >>> print(one.markdown())
    | stage | took, s |
    | --- | --- |
    | joint fit | 1.5 |
    >>> print(one.html())  # doctest: +ELLIPSIS
    <div class="scroll"><table class="cards">
    <thead><tr><th class="word">stage</th><th>took, s</th></tr></thead><tbody>
    <tr><th class="word">joint fit</th><td class="number" data-label="took, s">1.5</td></tr>
    </tbody></table></div>
    """

    columns: Sequence[Column]
    rows: Sequence[Row]
    group: str | None = None
    narrower: Sequence[Sequence[Sequence[Column]]] = ()
    tip: str = ""
    style: str = "cards"

    def print(self, console: Console) -> None:
        """Print the table on a terminal, without empty columns."""
        layouts = ([self.columns], *self.narrower)
        print_tables(
            console, [[shown_columns(columns, TERMINAL) for columns in layout] for layout in layouts], self.rows
        )

    def markdown(self) -> str:
        """Return the table as Markdown."""
        shown = shown_columns(self.columns, MARKDOWN)
        named = [self.group] if self.group and self.is_grouped else []
        lines = ([*([row[GROUP]] if named else []), *(_in_markdown(row, c) for c in shown)] for row in self.rows)
        return markdown_table([*named, *(c.label for c in shown)], lines)

    def html(self) -> Markup:
        """Return the table as HTML."""
        shown = shown_columns(self.columns, PAGE)
        heads = Markup("").join(map(_head, shown)) if any(column.label for column in shown) else ""
        head = Markup('<div class="scroll"><table class="{}">\n<thead><tr>{}</tr></thead><tbody>')
        parts = [head.format(self.style, heads)]
        before = None
        for row in self.rows:
            if self.is_grouped and row[GROUP] != before:
                before = row[GROUP]
                parts.append(Markup('<tr class="group"><th colspan="{}">{}</th></tr>').format(len(shown), before))
            tip = _attribute("title", row[self.tip] if self.tip else "")
            cells = Markup("").join(_on_page(row, c, first=k == 0) for k, c in enumerate(shown))
            parts.append(Markup("<tr{}>{}</tr>").format(tip, cells))
        return Markup("\n").join([*parts, Markup("</tbody></table></div>")])

    @property
    def is_grouped(self) -> bool:
        """Whether documents show the groups of the rows."""
        return self.group is not None and any(GROUP in row for row in self.rows)


def shown_columns(columns: Sequence[Column], where: str) -> list[Column]:
    """Return the columns that a printer shows."""
    return [c for c in columns if where in c.where]


def _head(column: Column) -> Markup:
    style = column.on_page.style
    left = column.words or (isinstance(style, str) and "word" in style)
    attributes = _attribute("class", "word" if left else "") + _attribute("aria-label", column.on_page.spoken)
    return Markup("<th{}>{}</th>").format(attributes, column.on_page.header or column.label)


def _in_markdown(row: Row, column: Column) -> str:
    text = cell_of(row, column.key)
    return Strong(text) if column.strong else text


def _on_page(row: Row, column: Column, *, first: bool) -> Markup:
    """Return a cell on a page; the first cell of a row is its header if it holds words."""
    own = column.on_page
    text = own.ink(row) if own.ink else cell_of(row, column.key)
    if first and column.words:
        head = own.style(row) if callable(own.style) else "word"
        return Markup('<th class="{}">{}</th>').format(head, text)
    style = own.style(row) if callable(own.style) else own.style or ("word" if column.words else "number")
    label = Markup("") if own.drops else Markup(' data-label="{}"').format(column.label)
    tip = _attribute("title", own.tip(row) if own.tip else "")
    style = _attribute("class", style + " whole" * own.wide) + _heat(own.heat(row) if own.heat else 0.0)
    return Markup("<td{}{}{}>{}</td>").format(style, label, tip, text)


def _heat(value: float) -> Markup:
    """Return the background of a cell, which is stronger for larger values."""
    colour = "heat" if value >= 0.0 else "cold"
    return _attribute("style", f"background: rgba(var(--{colour}), {opacity(value)})" if value else "")


def opacity(value: float) -> str:
    """Return the opacity of a cell's colour, for values from -1 to 1.

    Examples
    --------
    >>> opacity(-0.5), opacity(2.0)
    ('0.38', '0.75')
    """
    return f"{DARKEST * min(abs(value), 1.0) if math.isfinite(value) else 0.0:.2f}"


def _attribute(name: str, value: str) -> Markup:
    return Markup(' {}="{}"').format(name, value) if value else Markup("")
