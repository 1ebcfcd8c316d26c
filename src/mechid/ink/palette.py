"""Colours by meaning, for figures on paper and for light and dark pages.

Each colour of `MEANINGS` has the same meaning in every figure and on every page. Other curves (lines of sight,
requirements, units of a fleet, parameters) take the colours of `SERIES` in turn.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Colour:
    """One meaning: its colour on paper, and on light and dark pages, where thin lines need more contrast."""

    paper: str
    light: str
    dark: str


MEANINGS = {
    "measured": Colour("#56B4E9", "#56b4e9", "#3a8fc4"),
    "modelled": Colour("#D55E00", "#c04a00", "#ffb000"),
    "residual": Colour("#4D4D4D", "#5b6570", "#aab4bf"),
    "noise": Colour("#009E73", "#00795a", "#35c79a"),
    "resonance": Colour("#CC79A7", "#a3527f", "#e39ac5"),
    "order": Colour("#9AA3AD", "#9aa3ad", "#6d7782"),
    "estimate": Colour("#7A4EAB", "#7a4eab", "#c3a2f0"),
    "effect": Colour("#0072B2", "#0072b2", "#6aa9ff"),
    "run": Colour("#8A7400", "#8a7400", "#d6c437"),
    "order-over": Colour("#FFFFFF", "#ffffff", "#ffffff"),
    "resonance-over": Colour("#FF8FC7", "#ff8fc7", "#ff8fc7"),
}
"""Colours by meaning; ``-over`` marks colours for lines over an image. The first four have no other use."""
MEASURED, MODELLED, RESIDUAL, NOISE, MARK, ORDER, ESTIMATE, EFFECT = (
    MEANINGS[name].paper
    for name in ("measured", "modelled", "residual", "noise", "resonance", "order", "estimate", "effect")
)
ORDER_OVER, MARK_OVER = MEANINGS["order-over"].paper, MEANINGS["resonance-over"].paper
INK, GRID, PAPER = "#000000", "#B0B0B0", "#FFFFFF"
# Cells of an image keep their colours on dark pages, so these are no colours of the page.
ON_DARK, ON_LIGHT = "#FEFEFE", "#010101"
"""Text colours in cells of an image."""
LIMIT = INK
"""Colour of a requirement or criterion, not used for curves."""
# The first and third differ by one digit from `effect` and `estimate`, since a colour on paper maps to one name.
_SERIES = (
    Colour("#0072B3", "#0072b3", "#5aa9e8"),
    Colour("#E69F00", "#c98a00", "#e6b84a"),
    Colour("#7A4EAC", "#7a4eac", "#c3a2f1"),
    Colour("#8A5A2B", "#8a5a2b", "#d0a27a"),
    Colour("#B8A900", "#9a8d00", "#cfc23a"),
    Colour("#8C8C8C", "#8c8c8c", "#8c8c8c"),
    Colour("#B9A3E3", "#a48bd8", "#8f78c4"),
    Colour("#1F7A8C", "#1f7a8c", "#6fc0d0"),
)
SERIES = tuple(colour.paper for colour in _SERIES)
"""Colours distinguishable from one another and from measured, modelled, residual and noise."""
_NAMED = {**MEANINGS, **{f"series-{k}": colour for k, colour in enumerate(_SERIES)}}
PAGE_NAMES = {
    **{colour.paper.lower(): name for name, colour in _NAMED.items() if not name.endswith("-over")},
    INK: "ink",
    GRID.lower(): "line",
    PAPER.lower(): "paper",
}
"""Custom properties of a page, by the colour on paper with the same meaning."""
_LIGHT, _DARK = ':root, :root[data-theme="light"]', ':root[data-theme="dark"]'
_DARK_SCREEN, _PRINT = ":root:not([data-theme])", ":root, :root[data-theme], :root:not([data-theme])"


def series(number: int) -> str:
    """Return the colour of a curve by its number, for curves without a fixed meaning."""
    return SERIES[number % len(SERIES)]


def colour_style() -> str:
    """Return the colours as custom properties of light and dark pages."""
    light, dark = _properties(lambda colour: colour.light), _properties(lambda colour: colour.dark)
    return (
        f"{_LIGHT} {{ {light} }}\n{_DARK} {{ {dark} }}\n"
        f"@media (prefers-color-scheme: dark) {{ {_DARK_SCREEN} {{ {dark} }} }}\n"
        f"@media print {{ {_PRINT} {{ {light} }} }}\n"
    )


def _properties(shade: Callable[[Colour], str]) -> str:
    return " ".join(f"--{name}: {shade(colour)};" for name, colour in _NAMED.items())
