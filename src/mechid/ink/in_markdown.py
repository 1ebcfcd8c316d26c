"""Markdown printer of a document, with its figures in a folder next to it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import chain

from mechid.ink.document import (
    Cards,
    Code,
    Document,
    Facts,
    Interactive,
    Lines,
    Part,
    Picture,
    Rows,
    Section,
    Verdict,
    Words,
    shown_on,
)
from mechid.ink.markdown_text import bullets, cell
from mechid.ink.text_table import MARKDOWN


def document_markdown(document: Document) -> str:
    """Convert a document to Markdown."""
    blocks = [f"# {cell(document.title)}"]
    blocks += [f"**Synthetic**: {cell(document.simulated)}"] if document.is_synthetic else []
    blocks += [cell(document.under)] if document.under else []
    for part in shown_on(document.parts, MARKDOWN):
        blocks += _blocks(part, 2)
    return "\n\n".join(blocks) + "\n"


def _blocks(part: Part, level: int) -> list[str]:
    """Return the blocks of a part, to be separated by empty lines."""
    return _PRINTERS[type(part)](part, level)


def _words(part: Words, level: int) -> list[str]:
    return [f"**{cell(part.text)}**" if part.style == "strong" else _with_emphasis(part.text)]


def _lines(part: Lines, level: int) -> list[str]:
    lines = "\n".join(f"- {_with_emphasis(line)}" for line in part.lines)
    return [*_heading(part.heading, level), lines] if part.lines else []


def _rows(part: Rows, level: int) -> list[str]:
    return [*([cell(part.caption)] if part.caption else []), part.table.markdown()]


def _facts(part: Facts, level: int) -> list[str]:
    return ["\n".join(f"- {cell(name)}: **{cell(value)}**" for name, value in part.pairs)]


def _code(part: Code, level: int) -> list[str]:
    return [f"```{part.language}\n{part.text.rstrip()}\n```"]


def _picture(part: Picture, level: int) -> list[str]:
    return [f"![{cell(part.words)}](<{f'{part.folder}/' if part.folder else ''}{part.name}.svg>)"]


def _interactive(part: Interactive, level: int) -> list[str]:
    return _picture(part.picture, level)


def _verdict(part: Verdict, level: int) -> list[str]:
    answers = [[*_heading(question, level), bullets(lines)] for question, lines in part.questions]
    return [f"**{cell(part.headline)}**", *chain.from_iterable(answers), *_lines(part.warnings, level)]


def _cards(part: Cards, level: int) -> list[str]:
    blocks: list[str] = []
    for card in part.cards:
        title = f"[{cell(card.title)}](<{card.link}>)" if card.link else f"**{cell(card.title)}**"
        cautions = [f"caution: {line}" for line in card.cautions]
        blocks += [f"{title}: {cell(card.headline)}", *([bullets(cautions)] if cautions else [])]
    return blocks


def _section(part: Section, level: int) -> list[str]:
    below = level + 1 if part.heading else level
    inner = (_blocks(one, below) for one in shown_on(part.parts, MARKDOWN))
    return [*_heading(part.heading, level), *chain.from_iterable(inner)]


def _heading(text: str, level: int) -> list[str]:
    return [f"{'#' * level} {cell(text)}"] if text else []


def _with_emphasis(text: str) -> str:
    return "**".join(cell(piece) if piece.strip() == piece else _space(piece) for piece in text.split("**"))


def _space(piece: str) -> str:
    """Return a piece of a sentence with the spaces at its ends, which `cell` would remove."""
    before, after = piece[: len(piece) - len(piece.lstrip())], piece[len(piece.rstrip()) :]
    return f"{before}{cell(piece)}{after}" if piece.strip() else piece


_PRINTERS: Mapping[type, Callable[..., list[str]]] = {
    Words: _words,
    Lines: _lines,
    Rows: _rows,
    Facts: _facts,
    Code: _code,
    Picture: _picture,
    Interactive: _interactive,
    Verdict: _verdict,
    Cards: _cards,
    Section: _section,
}
