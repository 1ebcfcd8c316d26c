"""Text tables that never cut names or numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from rich.console import Console
from rich.text import Text

from mechid.ink.data import Data

GAP = "  "
INDENT = "  "
CELL_STYLE = {"at bound": "yellow", "frozen": "yellow", "tied": "dim", "known": "dim"}
TERMINAL, MARKDOWN, PAGE, DOCX = "terminal", "markdown", "page", "docx"
"""Printers that can show a column."""
EVERYWHERE = (TERMINAL, MARKDOWN, PAGE, DOCX)

Row: TypeAlias = Data


@dataclass(frozen=True, kw_only=True)
class OnPage:
    """Presentation of a column on a page, besides its text.

    Parameters
    ----------
    ink : callable or None
        Returns the content of a cell if it differs from the text; escaped unless it is markup.
    style : str or callable
        CSS class of the cells, or a function of the row, instead of ``word`` or ``number``.
    tip : callable or None
        Returns the tooltip of a cell.
    wide : bool
        Whether the column takes the full width of small pages.
    drops : bool
        Whether the column is omitted on small pages.
    header : str
        Shorter header above the cells, if that of documents is too wide.
    spoken : str
        Header for screen readers, if the visible one is not meaningful.
    heat : callable or None
        Returns the strength of a cell's colour, at most 1; negative values take another colour.
    """

    ink: Callable[[Row], str] | None = None
    style: str | Callable[[Row], str] = ""
    tip: Callable[[Row], str] | None = None
    wide: bool = False
    drops: bool = False
    header: str = ""
    spoken: str = ""
    heat: Callable[[Row], float] | None = None


@dataclass(frozen=True)
class Column:
    """A column.

    Parameters
    ----------
    header : str
    key : str
        Key in the text of a row, else in the row itself.
    words : bool
        Whether the column holds words instead of numbers.
    style : str
        Style of the cells on a terminal.
    said : str or None
        Longer header for documents; None takes `header`.
    where : tuple of str
        Printers that show the column, from `EVERYWHERE`.
    strong : bool
        Whether its cells are emphasised in Markdown.
    on_page : OnPage
    """

    header: str
    key: str
    words: bool = False
    style: str = ""
    said: str | None = None
    where: tuple[str, ...] = EVERYWHERE
    strong: bool = False
    on_page: OnPage = OnPage()

    @property
    def label(self) -> str:
        """Header in documents."""
        return self.header if self.said is None else self.said


def print_tables(console: Console, layouts: Sequence[Sequence[Sequence[Column]]], rows: Sequence[Row]) -> None:
    """Print rows in the first layout that fits the console, else in the last.

    A layout is one or more tables of the same rows, each a sequence of columns.
    """
    fitting = (tables for tables in layouts if max(table_width(t, rows) for t in tables) <= console.width)
    for columns in next(fitting, layouts[-1]):
        print_table(console, columns, rows)


def print_table(console: Console, columns: Sequence[Column], rows: Sequence[Row]) -> None:
    """Print a table and an empty line; on a narrow console, lines run over instead of being cut."""
    for line in table_lines(columns, rows):
        console.print(line, soft_wrap=True)
    console.print()


def table_width(columns: Sequence[Column], rows: Sequence[Row]) -> int:
    """Return the width of the widest line."""
    return max(len(line) for line in table_lines(columns, rows))


def table_lines(columns: Sequence[Column], rows: Sequence[Row]) -> list[Text]:
    """Return header, rule and rows, grouped by ``table`` and without empty columns."""
    used = [c for c in columns if any(cell_of(row, c.key) for row in rows)] or list(columns)
    cells = [[_indent_cell(row, c, used[0]) for c in used] for row in rows]
    widths = [max([len(c.header), *(len(row[j]) for row in cells)]) for j, c in enumerate(used)]
    lines = [
        _line(used, widths, [c.header for c in used], "bold"),
        _line(used, widths, ["-" * w for w in widths], "none"),
    ]
    for table in dict.fromkeys(row.get("table", "") for row in rows):
        lines += [Text(table, style="bold")] if table else []
        chosen = [line for row, line in zip(rows, cells, strict=True) if row.get("table", "") == table]
        lines += [_line(used, widths, line) for line in chosen]
    return lines


def _line(columns: Sequence[Column], widths: Sequence[int], cells: Sequence[str], style: str = "") -> Text:
    line = Text(style=style)
    for j, (column, width, cell) in enumerate(zip(columns, widths, cells, strict=True)):
        padded = cell.ljust(width) if column.words else cell.rjust(width)
        line.append(GAP if j else "").append(padded, style=CELL_STYLE.get(cell, style or column.style))
    line.rstrip()
    return line


def _indent_cell(row: Row, column: Column, first: Column) -> str:
    return (INDENT if column is first and row.get("table") else "") + cell_of(row, column.key)


def cell_of(row: Row, key: str) -> str:
    """Return the text of a cell."""
    texts = row.get("text", {})
    return str(texts[key] if key in texts else row[key])
