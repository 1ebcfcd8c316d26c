"""Elements of WordprocessingML as text: runs, paragraphs, fields and bookmarks."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any
from xml.sax.saxutils import escape, quoteattr

from docx.oxml import parse_xml
from docx.oxml.ns import nsdecls

# XML 1.0 has no representation of these characters.
NOT_IN_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
REPLACEMENT = "\N{REPLACEMENT CHARACTER}"


def clean(text: str) -> str:
    r"""Return a text on one line without characters that XML cannot hold.

    Examples
    --------
    >>> clean("a\n b\x07") == "a b\N{REPLACEMENT CHARACTER}"
    True
    """
    return " ".join(NOT_IN_XML.sub(REPLACEMENT, text).split())


def run(text: str, *, bold: bool = False, size: int = 0, colour: str = "") -> str:
    """Return a run; `size` is in half points, `colour` in hexadecimal digits, each by the style where not given."""
    properties = "<w:b/>" * bold
    properties += f'<w:color w:val="{colour}"/>' if colour else ""
    properties += f'<w:sz w:val="{size}"/><w:szCs w:val="{size}"/>' if size else ""
    return f'<w:r><w:rPr>{properties}</w:rPr><w:t xml:space="preserve">{escape(text)}</w:t></w:r>'


def emphasis_runs(text: str) -> str:
    """Return runs in which the text between two ``**`` is bold."""
    return "".join(run(piece, bold=k % 2 == 1) for k, piece in enumerate(clean(text).split("**")) if piece)


def paragraph(content: str, style: str, *, keep: bool = False, more: str = "") -> str:
    """Return a paragraph of a style; `keep` keeps it on the page of the next one, `more` are further properties."""
    kept = "<w:keepNext/>" * keep
    return f"<w:p><w:pPr><w:pStyle w:val={quoteattr(style)}/>{kept}{more}</w:pPr>{content}</w:p>"


def field(instruction: str, shown: str) -> str:
    """Return a field with the text that it shows until the program that opens the file works it out."""
    return f"{field_start(instruction)}{run(shown) if shown else ''}{FIELD_END}"


def field_start(instruction: str) -> str:
    """Return the beginning of a field, up to the text that it shows."""
    return (
        '<w:r><w:fldChar w:fldCharType="begin"/></w:r>'
        f'<w:r><w:instrText xml:space="preserve"> {escape(instruction)} </w:instrText></w:r>'
        '<w:r><w:fldChar w:fldCharType="separate"/></w:r>'
    )


FIELD_END = '<w:r><w:fldChar w:fldCharType="end"/></w:r>'
TAB = "<w:r><w:tab/></w:r>"
PAGE_BREAK = '<w:p><w:r><w:br w:type="page"/></w:r></w:p>'


def bookmark(number: int, name: str, content: str) -> str:
    """Return content that other places can refer to by name."""
    return f'<w:bookmarkStart w:id="{number}" w:name={quoteattr(name)}/>{content}<w:bookmarkEnd w:id="{number}"/>'


def link_to(name: str, content: str) -> str:
    """Return content that leads to a bookmark."""
    return f'<w:hyperlink w:anchor={quoteattr(name)} w:history="1">{content}</w:hyperlink>'


def elements(blocks: Iterable[str]) -> list[Any]:
    """Return the elements of blocks of text."""
    return list(parse_xml(f"<w:body {nsdecls('w')}>{''.join(blocks)}</w:body>"))
