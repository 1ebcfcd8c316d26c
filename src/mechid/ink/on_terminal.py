"""Terminal printer of a document: tables and lines that scripts can search for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from rich.console import Console

from mechid.ink.console import print_lines, say
from mechid.ink.document import (
    BAD,
    CAUTION,
    GOOD,
    Cards,
    Code,
    Document,
    Facts,
    Lines,
    Part,
    Rows,
    Section,
    Verdict,
    Words,
    shown_on,
)
from mechid.ink.text_table import INDENT, TERMINAL

STYLES = {GOOD: "bold green", CAUTION: "bold yellow", BAD: "bold red"}
STRONG = "bold"


def print_document(document: Document, console: Console, files: Sequence[Path] = ()) -> None:
    """Print a document and the paths of its files."""
    if document.is_synthetic:
        say(console, f"SYNTHETIC: {document.simulated}", STRONG)
    parts = shown_on(document.parts, TERMINAL)
    for before, part in zip([None, *parts], parts, strict=False):
        if isinstance(before, Section) and not _ends_with_table(before):
            console.print()
        _print(part, console)
    print_lines(console, "written", map(str, files))


def _print(part: Part, console: Console) -> None:
    _PRINTERS[type(part)](part, console)


def _words(part: Words, console: Console) -> None:
    say(console, part.text.replace("**", ""), STRONG if part.style == "strong" else "")


def _lines(part: Lines, console: Console) -> None:
    if part.word:
        print_lines(console, part.word, part.lines, part.style)
        return
    for line in part.lines:
        say(console, f"{INDENT}{line}", part.style)


def _rows(part: Rows, console: Console) -> None:
    if part.caption:
        say(console, part.caption, STRONG)
    part.table.print(console)


def _facts(part: Facts, console: Console) -> None:
    _lines(Lines([f"{name}: {value}" for name, value in part.pairs]), console)


def _code(part: Code, console: Console) -> None:
    for line in part.text.splitlines():
        say(console, f"{INDENT}{line}")


def _verdict(part: Verdict, console: Console) -> None:
    say(console, part.headline, STYLES.get(part.tone, STRONG))
    for question, answers in part.questions:
        say(console, question, STRONG)
        _lines(Lines(answers), console)
    if part.questions:
        console.print()
    if TERMINAL in part.warnings.where:
        _lines(part.warnings, console)


def _cards(part: Cards, console: Console) -> None:
    for card in part.cards:
        say(console, f"{INDENT}{card.title}: {card.headline}", STYLES.get(card.tone, ""))
        for line in card.cautions:
            say(console, f"{INDENT}caution: {line}", "yellow")


def _section(part: Section, console: Console) -> None:
    if part.heading:
        say(console, part.heading, STRONG)
    for inner in shown_on(part.parts, TERMINAL):
        _print(inner, console)


def _ends_with_table(part: Part) -> bool:
    """Return whether a part ends with a table, which is followed by an empty line."""
    if isinstance(part, Section):
        return _ends_with_table(shown_on(part.parts, TERMINAL)[-1])
    return isinstance(part, Rows)


_PRINTERS: Mapping[type, Callable[..., None]] = {
    Words: _words,
    Lines: _lines,
    Rows: _rows,
    Facts: _facts,
    Code: _code,
    Verdict: _verdict,
    Cards: _cards,
    Section: _section,
}
