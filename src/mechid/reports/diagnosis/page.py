"""A diagnosis as one HTML file that needs nothing beside it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from mechid.ink.template import environment, page_style
from mechid.ink.themed import themed
from mechid.reports.diagnosis.verdict import ACTS, DOTTED, PATH_TITLE, SPECTRUM, STRETCH, next_lines, sentence
from mechid.reports.fit.path import MEANING
from mechid.reports.fit.tables import own_table, path_table


def diagnosis_page(data: Mapping[str, Any], figures: Mapping[str, str]) -> str:
    """Return the page of what `diagnosis_data` made, with its figures as SVG by name."""
    sentences = {one["name"]: sentence(one) for one in data["missing"]}
    words = {
        "next": next_lines(data),
        "acts": f"{DOTTED} {ACTS}",
        "spectrum": SPECTRUM,
        "stretch": STRETCH,
        "meaning": MEANING,
        "path": PATH_TITLE,
    }
    template = environment().get_template("diagnose.html")
    return template.render(
        data=data,
        sentences=sentences,
        words=words,
        figures={name: Markup(themed(text)) for name, text in figures.items()},
        path=path_table(data["path"]).html(),
        own=lambda rows: own_table(rows).html(),
        style=page_style(),
    )
