"""A fleet's report as one HTML file that needs nothing beside it; its figures take the page's colours."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from mechid.ink.template import environment, page_style
from mechid.ink.themed import themed
from mechid.reports.fleet import tables
from mechid.reports.fleet.verdict import SYNTHETIC


def fleet_page(data: Mapping[str, Any], pictures: Mapping[str, str]) -> str:
    """Return the page.

    Parameters
    ----------
    data : mapping
        As `fleet_contents` makes it.
    pictures : mapping of str to str
        The figures as SVG, by name.
    """
    figures = {name.removeprefix("fleet_"): Markup(themed(text)) for name, text in pictures.items()}
    template = environment().get_template("fleet.html")
    return template.render(data=data, figures=figures, tables=tables, style=page_style(), synthetic_words=SYNTHETIC)
