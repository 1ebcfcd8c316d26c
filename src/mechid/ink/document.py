"""Document of a result: parts that are printed on a terminal, in Markdown, on a page and in Word.

Each capability makes one document of its result (`document.py` in its folder); the printers are `ink.on_terminal`,
`ink.in_markdown`, `ink.on_page` and `ink.in_docx`. The attribute `where` limits a part to some printers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from mechid.display import SIMULATED
from mechid.ink.sheet import FOLDER_NAME
from mechid.ink.table import Table
from mechid.ink.text_table import DOCX, EVERYWHERE, MARKDOWN, PAGE, TERMINAL

IN_DOCUMENTS = (MARKDOWN, PAGE, DOCX)
ON_TERMINAL = (TERMINAL,)
GOOD, CAUTION, BAD = "good", "caution", "bad"
"""Tones of a verdict."""
# More entries would fill the first screen.
MOST_ENTRIES = 40
"""Most top-level sections in the contents of a page."""


@dataclass(frozen=True, kw_only=True)
class _Part:
    where: tuple[str, ...] = EVERYWHERE


@dataclass(frozen=True)
class Words(_Part):
    """A paragraph; text between two ``**`` is emphasised.

    Attributes
    ----------
    text : str
    style : str
        ``strong``, ``soft``, or empty.
    where : tuple of str
        Printers that show the part, from `EVERYWHERE`; likewise for all parts below.
    """

    text: str
    style: str = ""


@dataclass(frozen=True)
class Lines(_Part):
    """A list of lines.

    Attributes
    ----------
    lines : sequence of str
        Lines; if empty, nothing is printed.
    word : str
        Prefix of each line on a terminal.
    heading : str
        Heading in documents.
    style : str
        Style of the lines on a terminal.
    """

    lines: Sequence[str]
    word: str = ""
    heading: str = ""
    style: str = ""


@dataclass(frozen=True)
class Rows(_Part):
    """A table, omitted without rows.

    Attributes
    ----------
    table : Table
    caption : str
        Caption above the table.
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
        Title on a page, where the lines can be folded.
    """

    text: str
    language: str = "toml"
    summary: str = ""
    where: tuple[str, ...] = field(default=IN_DOCUMENTS, kw_only=True)


@dataclass(frozen=True)
class Picture(_Part):
    """A figure from the folder of the result.

    Attributes
    ----------
    name : str
        Name of its files, without a suffix.
    words : str
        Text alternative for readers who cannot see the figure.
    folder : str
        Folder of its files, relative to the document; empty for the same folder.
    """

    name: str
    words: str
    folder: str = FOLDER_NAME
    where: tuple[str, ...] = field(default=IN_DOCUMENTS, kw_only=True)


@dataclass(frozen=True)
class Interactive(_Part):
    """A figure of a record drawn by the script of a page; elsewhere, or without script, a picture.

    Attributes
    ----------
    picture : Picture
    kinds : sequence of str
        Kinds of figures of the script, shown side by side.
    record : str
        Key of the curves in the script.
    stretches : sequence of (str, float, float)
        Buttons, each with the range of record time in s that it shows in the first figure.
    """

    picture: Picture
    kinds: Sequence[str]
    record: str
    stretches: Sequence[tuple[str, float, float]] = ()
    where: tuple[str, ...] = field(default=IN_DOCUMENTS, kw_only=True)


@dataclass(frozen=True)
class Html(_Part):
    """A piece of HTML, shown on pages only.

    Attributes
    ----------
    html : str
        HTML with all texts escaped.
    """

    html: str
    where: tuple[str, ...] = field(default=(PAGE,), kw_only=True)


@dataclass(frozen=True)
class Verdict(_Part):
    """Summary of a result.

    Attributes
    ----------
    headline : str
    questions : sequence of (str, sequence of str)
        Questions, each with its answers.
    tone : str
        `GOOD`, `CAUTION` or `BAD`; empty if neutral.
    warnings : Lines
        Warnings below the answers.
    """

    headline: str
    questions: Sequence[tuple[str, Sequence[str]]] = ()
    tone: str = ""
    warnings: Lines = Lines(())


@dataclass(frozen=True, kw_only=True)
class Card:
    """Summary of another result.

    Attributes
    ----------
    title : str
    link : str
        Address of its page; empty if there is none.
    under : str
        One line under the title.
    headline : str
    tone : str
        Tone of the headline, as for a verdict.
    lines : sequence of str
    cautions : sequence of str
    command : str
        Command for the user to type.
    picture : str
        Address of its picture; empty if there is none.
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
    """Summaries side by side, omitted if there are none.

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
        Heading; empty to group parts without one.
    parts : sequence of parts
        Parts; sections among them are one level lower.
    key : str
        Anchor in the addresses of a page.
    entry : str
        Title in the contents of a page; empty to omit it there. Without a heading, it is the common title of the
        sections inside, which are folded if they are many.
    is_folded : bool
        Whether a page initially shows only the heading.
    side_by_side : bool
        Whether a page shows its parts side by side if there is room.
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
    """Complete presentation of a result.

    Attributes
    ----------
    title : str
    command : str
        Command that made the result, as ``mechid budget``.
    under : str
        One line under the title.
    tab : str
        Title in the browser, in addition to the command; empty takes the title.
    is_synthetic : bool
        Whether its records were simulated, which is stated first.
    simulated : str
        Text of that statement.
    parts : sequence of parts
    shows_files : bool
        Whether its page shows pictures from other files, as `Cards` do.
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
        """Return the sections in the contents of a page in order, with the title of their folded group, if any."""
        return _contents(self.parts)


def shown_on(parts: Sequence[Part], printer: str) -> list[Part]:
    """Return the parts that a printer shows, without empty sections and lists."""
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
