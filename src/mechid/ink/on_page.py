"""A document as one HTML file that needs nothing beside it; its figures take the page's colours."""

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
from mechid.ink.themed import themed

MOST_PICTURES = 200
"""Of interactive figures that a page holds: those of 500 records are 160 MB. A page of more names their files."""


@dataclass(frozen=True, kw_only=True)
class Script:
    """What a page's script draws `Interactive` parts with.

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
    """Return the page of a document.

    Parameters
    ----------
    document : Document
    figures : mapping of str to str
        As SVG, by name; a picture that is not among them is left out.
    style : str
        Rules that no other page has.
    """
    drawn = {name: Markup(themed(text)) for name, text in figures.items()}
    return "".join(_pieces("document.html", document, style, figures=drawn))


def interactive_page(document: Document, pictures: Mapping[str, Path], script: Script) -> Iterator[str]:
    """Return the page of a document that has `Interactive` parts, in pieces made as they are asked for.

    Parameters
    ----------
    document : Document
    pictures : mapping of str to Path
        SVG files of the parts' pictures, by name; those of too many for one page it names.
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
    return (
        environment()
        .get_template(template)
        .generate(
            document=document,
            parts=_without_groups(document.parts),
            shown=_shown_on_page,
            kind_of=_name_of_kind,
            emphasised=emphasised,
            style=page_style() + style,
            **more,
        )
    )


def _without_groups(parts: Sequence[Part]) -> list[Part]:
    """Return the parts shown, those of sections without a heading by themselves, so that each makes a piece."""
    return list(chain.from_iterable(map(_one_or_its_parts, shown_on(parts, PAGE))))


def _one_or_its_parts(part: Part) -> list[Part]:
    return _without_groups(part.parts) if isinstance(part, Section) and not part.heading else [part]


def _in_base64(file: Path) -> str:
    return base64.b64encode(file.read_bytes()).decode()


def emphasised(text: str) -> Markup:
    """Return a text with what stands between two ``**`` in bold.

    Examples
    --------
    >>> print(emphasised("met where the **lower limit** is < 0"))
    met where the <b>lower limit</b> is &lt; 0
    """
    pieces = text.split("**")
    return Markup("").join(Markup("<b>{}</b>").format(p) if k % 2 else escape(p) for k, p in enumerate(pieces))


def _shown_on_page(parts: list[Part]) -> list[Part]:
    return shown_on(parts, PAGE)


def _name_of_kind(part: Part) -> str:
    return type(part).__name__
