"""A table of a report as a value: its columns once, and three printers, for a terminal, Markdown and a page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup
from rich.console import Console

from mechid.reports.markdown_text import table as markdown_table
from mechid.reports.text_table import Column, Row, cell_of, print_table

GROUP = "table"
"""Key of the name under which a row stands."""


@dataclass(frozen=True)
class Table:
    """Columns, and rows with a text for each.

    Parameters
    ----------
    columns : sequence of Column
    rows : sequence of mapping
        A cell is ``row["text"][key]``, else ``row[key]``. Rows with a ``table`` stand under that name.
    group : str
        What that name is called where it has a column of its own, as in Markdown.

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
    group: str = ""

    def print(self, console: Console) -> None:
        """Print it on a terminal; columns without any text are left out."""
        print_table(console, [c for c in self.columns if not c.on_page], self.rows)

    def markdown(self) -> str:
        """Return it as Markdown."""
        shown = [c for c in self.columns if not c.on_page]
        named = [self.group] if self._grouped else []
        lines = ([*([row[GROUP]] if named else []), *(cell_of(row, c.key) for c in shown)] for row in self.rows)
        return markdown_table([*named, *(c.said or c.header for c in shown)], lines)

    def html(self) -> Markup:
        """Return it for a page."""
        heads = Markup("").join(
            Markup("<th{}>{}</th>").format(_class("word" if c.words else ""), c.said or c.header) for c in self.columns
        )
        parts = [Markup('<div class="scroll"><table class="cards">\n<thead><tr>{}</tr></thead><tbody>').format(heads)]
        before = None
        for row in self.rows:
            if self._grouped and row[GROUP] != before:
                before = row[GROUP]
                parts.append(
                    Markup('<tr class="group"><th colspan="{}">{}</th></tr>').format(len(self.columns), before)
                )
            parts.append(Markup("<tr>{}</tr>").format(Markup("").join(self._page_cells(row))))
        return Markup("\n").join([*parts, Markup("</tbody></table></div>")])

    def _page_cells(self, row: Row) -> list[Markup]:
        cells = []
        for k, c in enumerate(self.columns):
            kind = ("word" if c.words else "number") + (" whole" if c.wide else "")
            label = c.said or c.header
            if k == 0 and c.words:
                cells.append(Markup('<th class="word">{}</th>').format(cell_of(row, c.key)))
            else:
                cells.append(Markup('<td{} data-label="{}">{}</td>').format(_class(kind), label, cell_of(row, c.key)))
        return cells

    @property
    def _grouped(self) -> bool:
        return bool(self.group) and any(GROUP in row for row in self.rows)


def _class(name: str) -> Markup:
    return Markup(' class="{}"').format(name) if name else Markup("")
