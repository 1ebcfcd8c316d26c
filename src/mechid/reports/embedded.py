"""BokehJS and the interactive figures as a page holds them, made once and then kept in the cache.

To import Bokeh and to make the figures takes a second, and what comes of it depends on no record: on Bokeh and on the
modules that make it alone, whose digest is in the file's name.
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
    ("mechid.reports", "embedded.py"),
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
def embedded() -> Embedded:
    """Return what a page embeds, from the cache where it is there; where it cannot be kept it is made each time."""
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
    """Return what the page's script draws the figures of some curves with."""
    made = embedded()
    return Script(library=made.library, kinds=made.kinds, records=[payload(one, resonances) for one in curves])


def _path() -> Path:
    texts = [files(package).joinpath(name).read_text(encoding="utf-8") for package, name in MAKERS]
    digest = hashlib.sha256("\n".join([version("bokeh"), *texts]).encode()).hexdigest()
    return version_folder() / f"page_{digest[:24]}.json"
