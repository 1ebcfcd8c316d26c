"""Tables of a document in Word: widths, repeated header rows, and divisions of tables that a page cannot hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mechid.ink.docx_text import clean, paragraph, run
from mechid.ink.table import GROUP, Table, opacity, shown_columns
from mechid.ink.text_table import DOCX, Column, Row, cell_of

SIZES = (17, 15, 14)
"""Sizes of the letters in half points, the largest that fits is taken."""
PADDING_PT = 3.0
"""Space at both sides of a cell."""
# Rounded up from Arial; bold letters are wider.
DIGIT_EM, CAPITAL_EM, LETTER_EM, NARROW_EM, WIDE_EM, BOLD = 0.56, 0.72, 0.56, 0.34, 0.95, 1.08
"""Widths of characters, of the size of the letters."""
NARROW, WIDE = frozenset(" .,:;'|!ijlIft()[]-/"), frozenset("mwMW@%")
BREAKABLE = 30
"""Characters from which a word is broken between any two of them; digests have 64."""
MOST_TOGETHER = 10
"""Most rows of a table that is kept on one page."""
REPEATED = 0.35
"""Share of the page's width that the repeated columns of a divided table may take."""
MOST_TURNED = 4
"""Most rows of a table that is turned instead of divided."""
FULL = 0.6
"""Share of the page's width from which a table takes all of it."""
HEAD_FILL, GROUP_FILL = "D9E2EC", "EEF2F6"
HEAT, COLD = (11, 92, 173), (192, 74, 0)
"""Colours of cells with positive and negative values, as on a page in print."""
TWIPS = 20
"""Twips a point."""
STYLE = "TableText"


@dataclass(frozen=True)
class Cell:
    """Content of a cell."""

    text: str
    is_bold: bool = False
    fill: str = ""


@dataclass(frozen=True)
class Grid:
    """Cells of a table; a row that is a text is the title of the rows below it.

    Attributes
    ----------
    heads : sequence of str
        Header of each column.
    words : sequence of bool
        Whether a column holds words, which are aligned left and may be broken.
    rows : sequence of (sequence of Cell) or str
    """

    heads: Sequence[str]
    words: Sequence[bool]
    rows: Sequence[Sequence[Cell] | str]

    def columns(self, kept: Sequence[int]) -> Grid:
        """Return the grid of some columns."""
        rows = [row if isinstance(row, str) else [row[k] for k in kept] for row in self.rows]
        return Grid([self.heads[k] for k in kept], [self.words[k] for k in kept], rows)


def table_blocks(table: Table, width_pt: float) -> list[str]:
    """Return a table as blocks of WordprocessingML, several where it is wider than the page.

    A table of few rows is turned; otherwise its columns are divided, and the first ones, of words, are repeated.
    """
    grid = grid_of(table)
    size = _fitting_size(grid, width_pt)
    if size:
        return [_table(grid, size, width_pt)]
    turned = _turn_grid(grid)
    size = _fitting_size(turned, width_pt) if turned else 0
    if turned and size:
        return [_table(turned, size, width_pt)]
    return [_table(part, SIZES[-1], width_pt) for part in _divide_grid(grid, width_pt)]


def facts_block(pairs: Sequence[tuple[str, str]], width_pt: float) -> str:
    """Return names and values as a table without a header."""
    rows = [[Cell(clean(name), is_bold=True), Cell(clean(value))] for name, value in pairs]
    return _table(Grid(["", ""], [True, True], rows), SIZES[0], width_pt)


def grid_of(table: Table) -> Grid:
    """Return the cells that Word shows of a table, without empty columns."""
    shown = shown_columns(table.columns, DOCX)
    used = [c for c in shown if any(clean(cell_of(row, c.key)) for row in table.rows)] or shown
    rows: list[list[Cell] | str] = []
    before = None
    for row in table.rows:
        if table.is_grouped and row[GROUP] != before:
            before = row[GROUP]
            rows.append(clean(str(before)))
        rows.append([_cell(row, column) for column in used])
    return Grid([clean(column.label) for column in used], [column.words for column in used], rows)


def _cell(row: Row, column: Column) -> Cell:
    heat = column.on_page.heat(row) if column.on_page.heat else 0.0
    return Cell(clean(cell_of(row, column.key)), is_bold=column.strong, fill=_fill(heat) if heat else "")


def _fill(heat: float) -> str:
    """Return the colour of a cell on white paper."""
    share = float(opacity(heat))
    return "".join(f"{round(255 + share * (c - 255)):02X}" for c in (HEAT if heat > 0.0 else COLD))


def _turn_grid(grid: Grid) -> Grid | None:
    """Return the grid with its columns as rows; None of one with titles or too many rows."""
    cells = [row for row in grid.rows if not isinstance(row, str)]
    if len(cells) != len(grid.rows) or len(cells) > MOST_TURNED or len(grid.heads) <= 1:
        return None
    rows = [[Cell(head, is_bold=True), *(row[k] for row in cells)] for k, head in enumerate(grid.heads)]
    # The first row becomes the header.
    return Grid([cell.text for cell in rows[0]], [True] * len(rows[0]), rows[1:])


def _divide_grid(grid: Grid, width_pt: float) -> list[Grid]:
    """Return grids of as many columns as fit, each with the first columns, which name the rows."""
    least, _ = _widths(grid, SIZES[-1])
    words = next((k for k, in_words in enumerate(grid.words) if not in_words), len(grid.words))
    named = max([1, *(k for k in range(1, words + 1) if sum(least[:k]) <= REPEATED * width_pt)])
    parts = [list(range(named))]
    for k in range(named, len(grid.heads)):
        if sum(least[j] for j in parts[-1]) + least[k] > width_pt and len(parts[-1]) > named:
            parts.append(list(range(named)))
        parts[-1].append(k)
    # A last part of a single column looks like another table.
    each = -(-(len(grid.heads) - named) // len(parts))
    even = [[*range(named), *range(k, min(k + each, len(least)))] for k in range(named, len(least), each)]
    if all(sum(least[k] for k in kept) <= width_pt for kept in even):
        parts = even
    return [grid.columns(kept) for kept in parts]


def _fitting_size(grid: Grid, width_pt: float) -> int:
    """Return the largest size of letters with which no word has to be broken; 0 if there is none."""
    return next((size for size in SIZES if sum(_widths(grid, size)[0]) <= width_pt), 0)


def _widths(grid: Grid, size: int) -> tuple[list[float], list[float]]:
    """Return the width of each column in points: of its longest word, and of its longest text."""
    least, most = [], []
    for k, head in enumerate(grid.heads):
        cells = [Cell(head, is_bold=True), *(row[k] for row in grid.rows if not isinstance(row, str))]
        least.append(max(max(map(_word_width, _bold_words(cell)), default=0.0) for cell in cells))
        most.append(max(_text_width(cell.text) * (BOLD if cell.is_bold else 1.0) for cell in cells))
    points, pad = 0.5 * size, 2.0 * PADDING_PT
    return [points * w + pad for w in least], [points * w + pad for w in most]


def _bold_words(cell: Cell) -> list[tuple[str, float]]:
    return [(word, BOLD if cell.is_bold else 1.0) for word in cell.text.split()]


def _word_width(word: tuple[str, float]) -> float:
    return _text_width(word[0][:BREAKABLE]) * word[1]


def _text_width(text: str) -> float:
    """Return the width of a text in units of the size of its letters."""
    return sum(map(_character_width, text))


def _character_width(c: str) -> float:
    if c in NARROW:
        return NARROW_EM
    if c in WIDE:
        return WIDE_EM
    return DIGIT_EM if c.isdigit() else CAPITAL_EM if c.isupper() else LETTER_EM


def _column_widths(grid: Grid, size: int, width_pt: float) -> list[int]:
    """Return the widths of the columns in twips: at least their longest word, the room that is left by need."""
    least, most = _widths(grid, size)
    room = width_pt - sum(least)
    if sum(most) <= FULL * width_pt or room <= 0.0:
        chosen = most if sum(most) <= width_pt else least
        return [int(TWIPS * w) for w in chosen]
    need = [b - a for a, b in zip(least, most, strict=True)]
    total = sum(need) or 1.0
    # Beyond its longest text no column needs room, but a table of full width looks the same on all pages.
    return [int(TWIPS * (a + room * n / total)) for a, n in zip(least, need, strict=True)]


def _table(grid: Grid, size: int, width_pt: float) -> str:
    widths = _column_widths(grid, size, width_pt)
    columns = "".join(f'<w:gridCol w:w="{w}"/>' for w in widths)
    layout = _Layout(grid.words, widths, size)
    heads = [Cell(head, is_bold=True, fill=HEAD_FILL) for head in grid.heads]
    header = layout.row(heads, keep=True, more="<w:tblHeader/>") if any(grid.heads) else ""
    # A short table is not divided between pages: each row but the last is kept with the next one.
    together = len(grid.rows) <= MOST_TOGETHER
    keeps = [together and k < len(grid.rows) - 1 for k in range(len(grid.rows))]
    rows = "".join(
        layout.title(row) if isinstance(row, str) else layout.row(row, keep=keep)
        for row, keep in zip(grid.rows, keeps, strict=True)
    )
    wide = f'<w:tblW w:w="{sum(widths)}" w:type="dxa"/>'
    properties = f'<w:tblStyle w:val="TableLines"/>{wide}<w:tblLayout w:type="fixed"/>'
    return f"<w:tbl><w:tblPr>{properties}</w:tblPr><w:tblGrid>{columns}</w:tblGrid>{header}{rows}</w:tbl>"


@dataclass(frozen=True)
class _Layout:
    """Alignment and widths of columns in twips, and size of the letters in half points."""

    words: Sequence[bool]
    widths: Sequence[int]
    size: int

    def row(self, cells: Sequence[Cell], *, keep: bool, more: str = "") -> str:
        aligned = ("left" if in_words else "right" for in_words in self.words)
        content = "".join(
            self._cell(cell, width, align, keep=keep)
            for cell, width, align in zip(cells, self.widths, aligned, strict=True)
        )
        return f"<w:tr><w:trPr><w:cantSplit/>{more}</w:trPr>{content}</w:tr>"

    def title(self, text: str) -> str:
        """Return the title of the rows below it, which stays with the first of them."""
        cell = Cell(text, is_bold=True, fill=GROUP_FILL)
        content = self._cell(cell, sum(self.widths), "left", keep=True, span=len(self.widths))
        return f"<w:tr><w:trPr><w:cantSplit/></w:trPr>{content}</w:tr>"

    def _cell(self, cell: Cell, width: int, align: str, *, keep: bool, span: int = 1) -> str:
        spanned = f'<w:gridSpan w:val="{span}"/>' if span > 1 else ""
        fill = f'<w:shd w:val="clear" w:color="auto" w:fill="{cell.fill}"/>' if cell.fill else ""
        text = run(cell.text, bold=cell.is_bold, size=self.size) if cell.text else ""
        content = paragraph(text, STYLE, keep=keep, more=f'<w:jc w:val="{align}"/>')
        return f'<w:tc><w:tcPr><w:tcW w:w="{width}" w:type="dxa"/>{spanned}{fill}</w:tcPr>{content}</w:tc>'
