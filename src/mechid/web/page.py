"""The page's template: its own texts, the report's palette, and places for Bokeh's figures."""

from __future__ import annotations

from functools import lru_cache
from importlib.resources import files

from jinja2 import Template

from mechid.reports.template import asset, environment

PACKAGE = "mechid.web"


@lru_cache(maxsize=1)
def page_template() -> Template:
    """Return the template that Bokeh's server fills for each tab; what it inserts is escaped."""
    templates = environment(PACKAGE)
    own = files(PACKAGE).joinpath("templates")
    templates.globals |= {
        "style": asset("report.css") + own.joinpath("explorer.css").read_text(encoding="utf-8"),
        "script": asset("painted.js") + own.joinpath("explorer.js").read_text(encoding="utf-8"),
    }
    return templates.get_template("explorer.html")
