"""Conversion of figures on paper for a page: responsive width, and colours of the page."""

from __future__ import annotations

import re

from mechid.ink.palette import PAGE_NAMES

_HEAD = re.compile(r"^.*?(?=<svg)", re.DOTALL)
_PAINT = re.compile(r"(fill|stroke): ?(#[0-9a-fA-F]{6})")
_NAMES = re.compile(r' id="[a-zA-Z0-9-]+_\d+"')
_SIZE = re.compile(r'(<svg[^>]*?) width="[^"]+"')
_HEIGHT = re.compile(r'(<svg[^>]*?) height="[^"]+"')
_STYLE = re.compile(r"<style[^>]*>.*?</style>", re.DOTALL)
_METADATA = re.compile(r"<metadata>.*?</metadata>", re.DOTALL)


def adapt_svg(svg: str) -> str:
    """Adapt the SVG of a figure to a page: responsive width, and colours of the page.

    Examples
    --------
    >>> adapt_svg('<?xml?><svg width="9pt" height="4pt"><g id="axes_1"><path style="fill: #56b4e9"/></g></svg>')
    '<svg><g><path style="fill: var(--measured)"/></g></svg>'
    """

    def paint(found: re.Match[str]) -> str:
        name = PAGE_NAMES.get(found[2].lower())
        return f"{found[1]}: var(--{name})" if name else found[0]

    # In HTML, a style element inside an SVG applies to the whole page.
    text = _METADATA.sub("", _STYLE.sub("", _HEAD.sub("", svg)))
    text = _HEIGHT.sub(r"\1", _SIZE.sub(r"\1", text, count=1), count=1)
    # Matplotlib numbers its groups from 1 in each figure, and an id must be unique on a page.
    return _PAINT.sub(paint, _NAMES.sub("", text)).strip()
