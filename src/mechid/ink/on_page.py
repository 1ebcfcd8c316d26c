"""HTML printer of a document: one self-contained file, with figures in the colours of the page."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

from markupsafe import Markup, escape

from mechid.ink.document import Document, Part, Section, shown_on
from mechid.ink.template import asset, environment, page_style
from mechid.ink.text_table import PAGE
from mechid.ink.themed import adapt_svg

# Pictures of 500 records take 160 MB.
MOST_PICTURES = 200
"""Most pictures embedded in an interactive page; with more, the page names their files."""


@dataclass(frozen=True, kw_only=True)
class Script:
    """Library and data with which the script of a page draws `Interactive` parts.

    Attributes
    ----------
    library : str
        BokehJS, deflated in base64.
    kinds : mapping of str to Any
        Each kind of figure, as BokehJS embeds it.
    records : sequence of mapping
        Curves of each record, which JSON can hold.
    """

    library: str
    kinds: Mapping[str, Any]
    records: Sequence[Mapping[str, Any]]


def document_page(document: Document, figures: Mapping[str, str], style: str = "") -> str:
    """Convert a document to a page.

    Parameters
    ----------
    document : Document
    figures : mapping of str to str
        SVG figures by name; pictures without a figure are omitted.
    style : str
        Additional style rules of this page.
    """
    drawn = {name: Markup(adapt_svg(text)) for name, text in figures.items()}
    return "".join(_pieces("document.html", document, style, figures=drawn))


def interactive_page(document: Document, pictures: Mapping[str, Path], script: Script) -> Iterator[str]:
    """Yield the page of a document with `Interactive` parts in pieces.

    Parameters
    ----------
    document : Document
    pictures : mapping of str to Path
        SVG files of the pictures by name; if there are too many for one page, the page only names them.
    script : Script
    """
    more = {
        "pictures": pictures,
        "holds_pictures": len(pictures) <= MOST_PICTURES,
        "in_base64": _in_base64,
        "script": asset("painted.js") + asset("report.js"),
    }
    return _pieces("interactive.html", document, "", **more, **vars(script))


def _pieces(template: str, document: Document, style: str, **more: Any) -> Iterator[str]:
    # The page is generated in pieces, so that one of many records is never held in memory as a whole.
    return (
        environment()
        .get_template(template)
        .generate(
            document=document,
            parts=_without_groups(document.parts),
            shown=_shown_on_page,
            kind_of=_name_of_kind,
            emphasise=emphasise,
            style=page_style() + style,
            **more,
        )
    )


def _without_groups(parts: Sequence[Part]) -> list[Part]:
    """Return the shown parts, with sections without a heading replaced by their parts, so that pieces stay small."""
    return list(chain.from_iterable(map(_one_or_its_parts, shown_on(parts, PAGE))))


def _one_or_its_parts(part: Part) -> list[Part]:
    return _without_groups(part.parts) if isinstance(part, Section) and not part.heading else [part]


def _in_base64(file: Path) -> str:
    return base64.b64encode(file.read_bytes()).decode()


def emphasise(text: str) -> Markup:
    """Return a text with passages between two ``**`` in bold.

    Examples
    --------
    >>> print(emphasise("met where the **lower limit** is < 0"))
    met where the <b>lower limit</b> is &lt; 0
    """
    pieces = text.split("**")
    return Markup("").join(Markup("<b>{}</b>").format(p) if k % 2 else escape(p) for k, p in enumerate(pieces))


def _shown_on_page(parts: list[Part]) -> list[Part]:
    return shown_on(parts, PAGE)


def _name_of_kind(part: Part) -> str:
    return type(part).__name__
