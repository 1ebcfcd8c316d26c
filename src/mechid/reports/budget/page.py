"""The budget's report as one HTML file that needs nothing beside it; its figures take the page's colours."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from mechid.ink.template import environment, page_style
from mechid.ink.themed import themed
from mechid.reports.budget import tables


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
    return (
        environment().get_template("budget.html").render(data=data, figures=figures, tables=tables, style=page_style())
    )
