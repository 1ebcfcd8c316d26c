"""The templates of pages: where they are, and what they may do with a value."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from mechid.ink.palette import colour_style

INK = "mechid.ink"


def environment(*packages: str) -> Environment:
    """Return the environment of some packages' templates and those that all pages share; texts are escaped."""
    environment = Environment(
        loader=ChoiceLoader([PackageLoader(package) for package in (*packages, INK)]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["script_json"] = script_json
    return environment


def script_json(value: Any) -> Markup:
    r"""Return JSON that may stand within a script element: no text of it can end the element.

    Examples
    --------
    >>> print(script_json({"a": "</script>"}))
    {"a": "\u003c/script>"}
    """
    text = json.dumps(value, separators=(", ", ": "), allow_nan=False)
    return Markup(text.replace("<", "\\u003c"))


def page_style() -> str:
    """Return the style sheet of a page, with its colours."""
    return colour_style() + asset("report.css")


def asset(name: str) -> str:
    """Return the text of a file beside the templates."""
    return files(INK).joinpath("templates", name).read_text(encoding="utf-8")
