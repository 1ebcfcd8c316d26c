"""The budget's report as one HTML file that needs nothing beside it; its figures take the page's colours."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from mechid.report.figures import MARK, MEASURED, MODELLED, NOISE, RESIDUAL_COLOUR
from mechid.report.page import asset, environment

THEMED = {
    MEASURED: "measured", MODELLED: "modelled", NOISE: "noise", MARK: "resonance", RESIDUAL_COLOUR: "residual",
    "#000000": "ink", "#b0b0b0": "line", "#ffffff": "paper",
}  # fmt: skip
"""Colours of the figures on paper, and the page's of the same meaning."""
_HEAD = re.compile(r"^.*?(?=<svg)", re.DOTALL)
_PAINT = re.compile(r"(fill|stroke): ?(#[0-9a-fA-F]{6})")
_NAMES = re.compile(r' id="[a-zA-Z0-9-]+_\d+"')
_SIZE = re.compile(r'(<svg[^>]*?) width="[^"]+"')
_HEIGHT = re.compile(r'(<svg[^>]*?) height="[^"]+"')
_STYLE = re.compile(r"<style[^>]*>.*?</style>", re.DOTALL)
_METADATA = re.compile(r"<metadata>.*?</metadata>", re.DOTALL)


def budget_page(data: Mapping[str, Any], pictures: Mapping[str, str]) -> str:
    """Return the page.

    Parameters
    ----------
    data : mapping
        As `budget_contents` makes it.
    pictures : mapping of str to str
        The figures as SVG, by name.
    """
    figures = {name.removeprefix("budget_"): Markup(themed(text)) for name, text in pictures.items()}
    return environment().get_template("budget.html").render(data=data, figures=figures, style=asset("report.css"))


def themed(svg: str) -> str:
    """Return a figure's SVG to stand within the page: as wide as there is room, its colours the page's.

    Examples
    --------
    >>> themed('<?xml?><svg width="9pt" height="4pt"><g id="axes_1"><path style="fill: #56b4e9"/></g></svg>')
    '<svg><g><path style="fill: var(--measured)"/></g></svg>'
    """
    known = {colour.lower(): name for colour, name in THEMED.items()}

    def paint(found: re.Match[str]) -> str:
        name = known.get(found[2].lower())
        return f"{found[1]}: var(--{name})" if name else found[0]

    text = _METADATA.sub("", _STYLE.sub("", _HEAD.sub("", svg)))
    text = _HEIGHT.sub(r"\1", _SIZE.sub(r"\1", text, count=1), count=1)
    return _PAINT.sub(paint, _NAMES.sub("", text)).strip()
