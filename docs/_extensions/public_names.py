"""The pages of the Python interface, made from `mechid.__all__`: no name can lack, and each has a docstring."""

import inspect
from typing import Any

from sphinx.application import Sphinx
from sphinx.util import logging

import mechid

LOG = logging.getLogger(__name__)
FUNCTION = "```{{eval-rst}}\n.. autofunction:: mechid.{name}\n```\n"
VALUE = "```{{eval-rst}}\n.. autoclass:: mechid.{name}\n   :members:\n```\n"


def is_error(value: object) -> bool:
    """Tell of an error."""
    return inspect.isclass(value) and issubclass(value, Exception)


def is_value(value: object) -> bool:
    """Tell of a class that is no error."""
    return inspect.isclass(value) and not is_error(value)


PLACES = {
    "<!-- functions -->": (inspect.isroutine, FUNCTION),
    "<!-- values -->": (is_value, VALUE),
    "<!-- errors -->": (is_error, VALUE),
}
"""Where a page has them, which names those are, and what is written of each."""


def listed(app: Sphinx, name: str, source: list[str]) -> None:
    """Put the public names where a page asks for them."""
    for place, (belongs, text) in PLACES.items():
        if place in source[0]:
            names = [one for one in sorted(mechid.__all__) if belongs(getattr(mechid, one))]
            source[0] = source[0].replace(place, "\n".join(text.format(name=one) for one in names))


def documented(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Warn of a public name that says nothing of itself; a strict build refuses that."""
    if not any(line.strip() for line in lines):
        LOG.warning("%s has no docstring: say what it is, with shapes and units", name, type="mechid")


def setup(app: Sphinx) -> dict[str, bool]:
    """Look at each page, and at each docstring, as it is read."""
    app.connect("source-read", listed)
    app.connect("autodoc-process-docstring", documented)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
