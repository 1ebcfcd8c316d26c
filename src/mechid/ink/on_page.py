"""A document as one HTML file that needs nothing beside it; its figures take the page's colours."""

from __future__ import annotations

from collections.abc import Mapping

from markupsafe import Markup, escape

from mechid.ink.document import Document, Part, shown_on
from mechid.ink.template import environment, page_style
from mechid.ink.text_table import PAGE
from mechid.ink.themed import themed


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
    return (
        environment()
        .get_template("document.html")
        .render(
            document=document,
            parts=shown_on(document.parts, PAGE),
            shown=_shown_on_page,
            kind_of=_name_of_kind,
            emphasised=emphasised,
            figures={name: Markup(themed(text)) for name, text in figures.items()},
            style=page_style() + style,
        )
    )


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
