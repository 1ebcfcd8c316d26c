"""Word printer of a document: one file with numbered headings, captions, contents and pictures.

It needs python-docx (extra ``office``); `ink.docx_file` refuses a request where it is absent.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from docx.document import Document as WordFile
from docx.oxml.ns import qn
from docx.shared import Cm, Emu

from mechid.ink.document import (
    BAD,
    CAUTION,
    GOOD,
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
from mechid.ink.docx_layout import LEVELS, WIDTH_CM, WIDTH_PT, new_file
from mechid.ink.docx_table import facts_block, table_blocks
from mechid.ink.docx_text import (
    FIELD_END,
    PAGE_BREAK,
    TAB,
    bookmark,
    clean,
    elements,
    emphasis_runs,
    field,
    field_start,
    link_to,
    paragraph,
    run,
)
from mechid.ink.text_table import DOCX

TALLEST_CM = 21.0
"""Largest height of a picture, which leaves room for its caption."""
# Word becomes slow with more, and pictures of 500 records take 160 MB.
MOST_PICTURES = 200
"""Most pictures of a document; further ones are named by their files."""
COLOURS = {GOOD: "0B6B43", CAUTION: "8A5200", BAD: "A3241B"}
SPACE = '<w:p><w:pPr><w:pStyle w:val="TableText"/></w:pPr></w:p>'
"""Empty paragraph, without which Word would join two tables."""
CONTENTS = 'TOC \\o "1-2" \\h \\z \\u'
CONTENTS_LEVELS = 2


def document_docx(document: Document, pictures: Mapping[str, Path]) -> WordFile:
    """Convert a document to Word.

    Parameters
    ----------
    document : Document
        Its parts of `DOCX`.
    pictures : mapping of str to Path
        PNG files of the figures by name; pictures without a file are omitted.
    """
    printer = _Printer(new_file(document), pictures)
    printer.print_document(document)
    return printer.file


class _Printer:
    """State of a document that is printed: numbers of headings and captions, blocks that are not in the file yet."""

    def __init__(self, file: WordFile, pictures: Mapping[str, Path]) -> None:
        self.file, self.pictures = file, pictures
        self.body: Any = file.element.body
        self.blocks: list[str] = []
        self.counts = [0] * LEVELS
        self.numbers = {"Table": 0, "Figure": 0}
        self.entries: list[tuple[int, str, str]] = []
        self.heading = ""

    def print_document(self, document: Document) -> None:
        self.blocks.append(paragraph(run(clean(document.title)), "Title"))
        if document.under:
            self.blocks.append(paragraph(run(clean(document.under)), "Subtitle"))
        if document.is_synthetic:
            said = run(f"SYNTHETIC: {document.simulated}", colour=COLOURS[BAD])
            self.blocks.append(paragraph(said, "Verdict"))
        parts = shown_on(document.parts, DOCX)
        # What stands before the first heading belongs to the first page, with the contents.
        first = next((k for k, part in enumerate(parts) if isinstance(part, Section) and part.heading), len(parts))
        for part in parts[:first]:
            self.print_part(part, 1)
        at = self._flush() + 1
        for part in parts[first:]:
            self.print_part(part, 1)
        self._flush()
        if self.entries:
            for block in reversed(elements([*self._contents(), PAGE_BREAK])):
                self.body.insert(at, block)

    def print_part(self, part: Part, level: int) -> None:
        _PRINTERS[type(part)](self, part, level)

    def add_heading(self, text: str, level: int) -> None:
        if not text:
            return
        text, level = clean(text), min(level, LEVELS)
        self.counts[level - 1] += 1
        self.counts[level:] = [0] * (LEVELS - level)
        self.heading = text
        name, number = f"_Toc{len(self.entries) + 1:06d}", ".".join(map(str, self.counts[:level]))
        self.entries.append((level, f"{number}\t{text}", name))
        self.blocks.append(paragraph(bookmark(len(self.entries), name, run(text)), f"Heading{level}"))

    def add_caption(self, kind: str, text: str, *, keep: bool) -> None:
        self.numbers[kind] += 1
        numbered = run(f"{kind} ") + field(f"SEQ {kind} \\* ARABIC", str(self.numbers[kind]))
        self.blocks.append(paragraph(numbered + run(f": {clean(text)}"), "Caption", keep=keep))

    def add_picture(self, part: Picture) -> None:
        path = self.pictures.get(part.name)
        if path is None:
            return
        if self.numbers["Figure"] >= MOST_PICTURES:
            self.blocks.append(paragraph(run(clean(f"{part.words}: {part.folder}/{path.name}")), "Note"))
            return
        self._flush()
        shape: Any = self.file.add_picture(str(path), width=Cm(WIDTH_CM))
        tallest = Cm(TALLEST_CM)
        if shape.height > tallest:
            shape.width, shape.height = Emu(round(shape.width * tallest / shape.height)), tallest
        # Read aloud to those who cannot see the figure.
        shape._inline.docPr.set("descr", clean(part.words))
        shape._inline.docPr.set("name", clean(part.name))
        self.file.paragraphs[-1].style = "Picture"
        self.add_caption("Figure", part.words, keep=False)

    def _flush(self) -> int:
        """Append the waiting blocks to the file, and return the index of the last one in the body."""
        last = self.body.sectPr
        for block in elements(self.blocks):
            # lxml needs a time quadratic in the size of what is moved to another tree, so rows are moved one by one.
            rows = block.findall(qn("w:tr"))
            for row in rows:
                block.remove(row)
            last.addprevious(block)
            for row in rows:
                block.append(row)
        self.blocks = []
        return int(self.body.index(last)) - 1

    def _contents(self) -> list[str]:
        """Return the table of contents as a field, without page numbers until a program works it out."""
        shown = [entry for entry in self.entries if entry[0] <= CONTENTS_LEVELS]
        lines = []
        for k, (level, text, name) in enumerate(shown):
            number, words = text.split("\t")
            line = link_to(name, run(number) + TAB + run(words))
            start = field_start(CONTENTS) if k == 0 else ""
            end = FIELD_END if k == len(shown) - 1 else ""
            lines.append(paragraph(start + line + end, f"toc{level}"))
        return [paragraph(run("Contents"), "ContentsHeading", keep=True), *lines]


def _words(printer: _Printer, part: Words, level: int) -> None:
    del level
    content = run(clean(part.text), bold=True) if part.style == "strong" else emphasis_runs(part.text)
    printer.blocks.append(paragraph(content, "Note" if part.style == "soft" else "Normal"))


def _lines(printer: _Printer, part: Lines, level: int) -> None:
    if part.lines:
        printer.add_heading(part.heading, level)
        printer.blocks += [paragraph(emphasis_runs(line), "ListBullet") for line in part.lines]


def _rows(printer: _Printer, part: Rows, level: int) -> None:
    del level
    printer.add_caption("Table", part.caption or printer.heading, keep=True)
    for block in table_blocks(part.table, WIDTH_PT):
        printer.blocks += [block, SPACE]


def _facts(printer: _Printer, part: Facts, level: int) -> None:
    del level
    printer.blocks += [facts_block(part.pairs, WIDTH_PT), SPACE]


def _code(printer: _Printer, part: Code, level: int) -> None:
    del level
    lines = part.text.rstrip().splitlines()
    printer.blocks += [paragraph(run(_indent_line(line)), "Code") for line in lines]
    printer.blocks.append(SPACE)


def _indent_line(line: str) -> str:
    """Return a line of code with the spaces at its beginning."""
    return " " * (len(line) - len(line.lstrip())) + clean(line)


def _picture(printer: _Printer, part: Picture, level: int) -> None:
    del level
    printer.add_picture(part)


def _interactive(printer: _Printer, part: Interactive, level: int) -> None:
    del level
    printer.add_picture(part.picture)


def _verdict(printer: _Printer, part: Verdict, level: int) -> None:
    printer.blocks.append(paragraph(run(clean(part.headline), colour=COLOURS.get(part.tone, "")), "Verdict"))
    for question, answers in part.questions:
        _lines(printer, Lines(answers, heading=question), level)
    if DOCX in part.warnings.where:
        _lines(printer, part.warnings, level)


def _cards(printer: _Printer, part: Cards, level: int) -> None:
    for card in part.cards:
        printer.blocks.append(paragraph(emphasis_runs(f"**{card.title}**: {card.headline}"), "Normal"))
        _lines(printer, Lines([f"caution: {line}" for line in card.cautions]), level)


def _section(printer: _Printer, part: Section, level: int) -> None:
    printer.add_heading(part.heading, level)
    for inner in shown_on(part.parts, DOCX):
        printer.print_part(inner, level + 1 if part.heading else level)


_PRINTERS: Mapping[type, Callable[..., None]] = {
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
