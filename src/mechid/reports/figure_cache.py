"""Cache of BokehJS and of the interactive figures in the form that a page embeds.

Importing Bokeh and making the figures takes a second. The result depends on no record, only on the version of Bokeh and
on the modules that make the figures; their digest is part of the file name.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any

from mechid.ink.on_page import Script
from mechid.kernel.compiled import version_folder
from mechid.reports.curves import Curves
from mechid.reports.packing import pack_text
from mechid.reports.payload import payload
from mechid.writing import write_atomically

# A change of any of these files may change the figures, so the cache key covers their text.
MAKERS = (
    ("mechid.reports", "figure_cache.py"),
    ("mechid.reports", "plots.py"),
    ("mechid.ink", "quantities.py"),
    ("mechid.reports", "packing.py"),
)


@dataclass(frozen=True)
class Embedded:
    """BokehJS, deflated in base64, and each kind of figure as BokehJS embeds it, by name."""

    library: str
    kinds: dict[str, Any]


@cache
def embed_records() -> Embedded:
    """Return the embedded parts of a page from the cache; without a writable cache, make them each time."""
    path = _path()
    # A missing or damaged file is made anew; TypeError stands for keys of another version.
    with suppress(OSError, ValueError, TypeError):
        return Embedded(**json.loads(path.read_text(encoding="utf-8")))
    # Imported here, since a page with a cached file does not need Bokeh.
    from mechid.reports.plots import library, plot_items

    made = Embedded(library=pack_text(library()), kinds=plot_items())
    # An unwritable cache costs a second each time, but not the report.
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, json.dumps(vars(made)))
    return made


def page_script(curves: Sequence[Curves], resonances: Sequence[Mapping[str, Any]]) -> Script:
    """Return the library, figures and data with which the page's script draws curves."""
    made = embed_records()
    return Script(library=made.library, kinds=made.kinds, records=[payload(one, resonances) for one in curves])


def _path() -> Path:
    texts = [files(package).joinpath(name).read_text(encoding="utf-8") for package, name in MAKERS]
    digest = hashlib.sha256("\n".join([version("bokeh"), *texts]).encode()).hexdigest()
    return version_folder() / f"page_{digest[:24]}.json"
