"""The page's template: its own texts, the report's palette, and places for Bokeh's figures."""

from __future__ import annotations

from functools import lru_cache
from importlib.resources import files

from jinja2 import Template

from mechid.report.page import asset, page_environment

PACKAGE = "mechid.web"


@lru_cache(maxsize=1)
def page_template() -> Template:
    """Return the template that Bokeh's server fills for each tab; what it inserts is escaped."""
    environment = page_environment(PACKAGE)
    own = files(PACKAGE).joinpath("templates")
    environment.globals |= {
        "style": asset("report.css") + own.joinpath("explorer.css").read_text(encoding="utf-8"),
        "script": asset("painted.js") + own.joinpath("explorer.js").read_text(encoding="utf-8"),
    }
    return environment.get_template("explorer.html")
