"""A look as one HTML file that needs nothing beside it; its figures take the page's colours."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from mechid.ink.quantities import quantity_words
from mechid.ink.template import environment, page_style
from mechid.ink.themed import themed


def look_page(data: Mapping[str, Any], pictures: Mapping[str, str]) -> str:
    """Return the page.

    Parameters
    ----------
    data : mapping
        As `look_data` makes it.
    pictures : mapping of str to str
        The figures as SVG, by name.
    """
    figures = {name: Markup(themed(text)) for name, text in pictures.items()}
    template = environment().get_template("look.html")
    return template.render(data=data, figures=figures, style=page_style(), words=quantity_words)
