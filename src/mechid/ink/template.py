"""Templates of pages: loading, escaping and filters."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from mechid.ink.palette import colour_style

INK = "mechid.ink"


def environment(*packages: str) -> Environment:
    """Return the template environment of packages, with shared templates and escaped texts."""
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
    r"""Return JSON for use in a script element, without text that could end the element.

    Examples
    --------
    >>> print(script_json({"a": "</script>"}))
    {"a": "\u003c/script>"}
    """
    # Python's NaN literal is no JSON: a browser refuses it.
    text = json.dumps(value, separators=(", ", ": "), allow_nan=False)
    return Markup(text.replace("<", "\\u003c"))


def page_style() -> str:
    """Return the style sheet of pages, with the colours."""
    return colour_style() + asset("report.css")


def asset(name: str) -> str:
    """Return the text of a file in the template folder."""
    return files(INK).joinpath("templates", name).read_text(encoding="utf-8")
