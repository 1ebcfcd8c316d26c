"""The document of a result: parts that a terminal, Markdown and a page print each in its way.

A capability makes one document of its result (`document.py` in its folder); the printers are `ink.on_terminal`,
`ink.in_markdown` and `ink.on_page`. A part that only some of them show says so in `where`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from mechid.ink.sheet import FOLDER_NAME
from mechid.ink.table import Table
from mechid.ink.text_table import EVERYWHERE, MARKDOWN, PAGE, TERMINAL
from mechid.shown import SIMULATED

IN_DOCUMENTS = (MARKDOWN, PAGE)
ON_TERMINAL = (TERMINAL,)
GOOD, CAUTION, BAD = "good", "caution", "bad"
"""Tones of a verdict."""
MOST_ENTRIES = 40
"""Of sections without a heading over them that a page's contents show: more would fill the first screen."""


@dataclass(frozen=True, kw_only=True)
class _Part:
    where: tuple[str, ...] = EVERYWHERE


@dataclass(frozen=True)
class Words(_Part):
    """A paragraph; what stands between two ``**`` stands out.

    Attributes
    ----------
    text : str
    style : str
        ``strong``, ``soft``, or empty.
    where : tuple of str
        Printers that show the part, of `EVERYWHERE`; so of each part below.
    """

    text: str
    style: str = ""


@dataclass(frozen=True)
class Lines(_Part):
    """A list of lines.

    Attributes
    ----------
    lines : sequence of str
        Nothing is printed of none.
    word : str
        Begins each line on a terminal.
    heading : str
        Above them in documents.
    style : str
        Of the lines on a terminal.
    """

    lines: Sequence[str]
    word: str = ""
    heading: str = ""
    style: str = ""


@dataclass(frozen=True)
class Rows(_Part):
    """A table, left out where it has no rows.

    Attributes
    ----------
    table : Table
    caption : str
        Above it.
    """

    table: Table
    caption: str = ""


@dataclass(frozen=True)
class Facts(_Part):
    """Values with their names, side by side on a page.

    Attributes
    ----------
    pairs : sequence of (str, str)
        Name and value.
    """

    pairs: Sequence[tuple[str, str]]


@dataclass(frozen=True)
class Code(_Part):
    """Lines of a file.

    Attributes
    ----------
    text : str
    language : str
    summary : str
        What a page, which can fold them, calls them.
    """

    text: str
    language: str = "toml"
    summary: str = ""
    where: tuple[str, ...] = field(default=IN_DOCUMENTS, kw_only=True)


@dataclass(frozen=True)
class Picture(_Part):
    """A figure of the result's folder.

    Attributes
    ----------
    name : str
        Of its files, without a suffix.
    words : str
        What it shows, for who cannot see it.
    folder : str
        Of its files, from the document; empty: beside it.
    """

    name: str
    words: str
    folder: str = FOLDER_NAME
    where: tuple[str, ...] = field(default=IN_DOCUMENTS, kw_only=True)


@dataclass(frozen=True)
class Interactive(_Part):
    """A figure that a page's script draws of a record; its picture on paper, in Markdown and where no script runs.

    Attributes
    ----------
    picture : Picture
    kinds : sequence of str
        Of the script's figures, side by side.
    record : str
        By which the script knows the curves.
    stretches : sequence of (str, float, float)
        Buttons, each with the record time in s from which and to which it shows the first figure.
    """

    picture: Picture
    kinds: Sequence[str]
    record: str
    stretches: Sequence[tuple[str, float, float]] = ()
    where: tuple[str, ...] = field(default=IN_DOCUMENTS, kw_only=True)


@dataclass(frozen=True)
class Html(_Part):
    """A piece of a page alone, as HTML.

    Attributes
    ----------
    html : str
        Shown as it is: every text in it is escaped already.
    """

    html: str
    where: tuple[str, ...] = field(default=(PAGE,), kw_only=True)


@dataclass(frozen=True)
class Verdict(_Part):
    """What a result comes to.

    Attributes
    ----------
    headline : str
    questions : sequence of (str, sequence of str)
        Each with its answers.
    tone : str
        `GOOD`, `CAUTION`, `BAD`; empty where it is none of these.
    warnings : Lines
        Under the answers.
    """

    headline: str
    questions: Sequence[tuple[str, Sequence[str]]] = ()
    tone: str = ""
    warnings: Lines = Lines(())


@dataclass(frozen=True, kw_only=True)
class Card:
    """Another result in short.

    Attributes
    ----------
    title : str
    link : str
        Address of its page; empty: it has none.
    under : str
        One line under the title.
    headline : str
    tone : str
        Of the headline, as of a verdict.
    lines : sequence of str
    cautions : sequence of str
    command : str
        To be typed.
    picture : str
        Address of a picture of it; empty: it has none.
    """

    title: str
    headline: str
    link: str = ""
    under: str = ""
    tone: str = ""
    lines: Sequence[str] = ()
    cautions: Sequence[str] = ()
    command: str = ""
    picture: str = ""


@dataclass(frozen=True)
class Cards(_Part):
    """Results side by side, left out where there are none.

    Attributes
    ----------
    cards : sequence of Card
    """

    cards: Sequence[Card]


@dataclass(frozen=True)
class Section(_Part):
    """Parts under a heading.

    Attributes
    ----------
    heading : str
        Empty: they stand together without one.
    parts : sequence of parts
        Sections among them are one level lower.
    key : str
        By which a page's addresses name it.
    entry : str
        What the page's contents call it; empty: they do not have it. Where it has no heading, what they call the
        sections in it together, behind which they fold away where they are many.
    is_folded : bool
        Whether a page shows the heading alone at first.
    side_by_side : bool
        Whether a page sets its parts beside one another where there is room.
    """

    heading: str
    parts: Sequence[Part]
    key: str = ""
    entry: str = ""
    is_folded: bool = False
    side_by_side: bool = False


Part: TypeAlias = Words | Lines | Rows | Facts | Code | Picture | Interactive | Html | Verdict | Cards | Section


@dataclass(frozen=True, kw_only=True)
class Document:
    """All that is shown of a result.

    Attributes
    ----------
    title : str
    command : str
        That made it, as ``mechid budget``.
    under : str
        One line under the title.
    tab : str
        What a browser calls its page, beside the command; empty takes the title.
    is_synthetic : bool
        Whether its records were simulated, which is said first.
    simulated : str
        What is said of that.
    parts : sequence of parts
    shows_files : bool
        Whether its page shows pictures of other files, as `Cards` do.
    """

    title: str
    command: str
    under: str = ""
    tab: str = ""
    is_synthetic: bool = False
    simulated: str = SIMULATED
    parts: Sequence[Part] = ()
    shows_files: bool = False

    def contents(self) -> list[tuple[str, list[Section]]]:
        """Return the sections that a page's contents have, in order, and what they fold behind; empty: they do not."""
        return _contents(self.parts)


def shown_on(parts: Sequence[Part], printer: str) -> list[Part]:
    """Return the parts that a printer shows; sections and lists without anything in them are left out."""
    return [part for part in parts if printer in part.where and not _is_empty(part, printer)]


def _is_empty(part: Part, printer: str) -> bool:
    match part:
        case Section():
            return not shown_on(part.parts, printer)
        case Lines():
            return not part.lines
        case Rows():
            return not part.table.rows
        case Facts():
            return not part.pairs
        case Cards():
            return not part.cards
        case Words() | Code():
            return not part.text
        case _:
            return False


def _contents(parts: Sequence[Part]) -> list[tuple[str, list[Section]]]:
    found: list[tuple[str, list[Section]]] = []
    for part in shown_on(parts, PAGE):
        if isinstance(part, Section):
            own = [("", [part])] if part.entry and part.heading else []
            within = _contents(part.parts)
            entries = [section for _, sections in within for section in sections]
            is_many = not part.heading and part.entry and len(entries) > MOST_ENTRIES
            found += [*own, *([(f"{len(entries)} {part.entry}", entries)] if is_many else within)]
    return found
