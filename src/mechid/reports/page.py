"""The report as one HTML file that needs nothing beside it."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Callable, Mapping, Sequence
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from mechid.kernel.equation_text import Section
from mechid.reports import shared_tables
from mechid.reports.curves import Curves
from mechid.reports.embedded import embedded
from mechid.reports.outline import DETAIL_S, Outline
from mechid.reports.path import COMPLETED_TITLE
from mechid.reports.payload import payload
from mechid.reports.quantities import quantity_words
from mechid.reports.side import SIDE_SAID, SIDE_TITLE
from mechid.reports.table import Table
from mechid.units import unit_words

OUTLINED = (
    "A long record: the figure shows the least and the largest sample of every {column:.3g} s of it, and every sample "
    "of {detail:.3g} s around what the buttons name."
)
DARKEST = 0.75
"""Opacity of a cell's colour at most, so that its number stays legible."""
TABLES: Mapping[str, Callable[[Sequence[Any]], Table]] = {
    "beside": shared_tables.beside_table,
    "orders": shared_tables.order_table_of_one,
    "own": shared_tables.own_table,
    "path": shared_tables.path_table,
    "side": shared_tables.side_table,
    "stages": shared_tables.stage_table,
}


def report_page(
    data: Mapping[str, Any], curves: Sequence[Curves], pictures: Mapping[str, str], equations: Sequence[Section]
) -> str:
    """Return the page.

    Parameters
    ----------
    data : mapping
        As `report_contents` makes it.
    curves : sequence of Curves
        Of the records, in their order.
    pictures : mapping of str to str
        The figures on paper as SVG, by name; they are shown in print and where no script runs.
    equations : sequence of Section
        In MathML.
    """
    drawn = [payload(one, data["resonances"]) for one in curves]
    return (
        environment()
        .get_template("report.html")
        .render(
            data={**data, "curves": [_shown(one) for one in curves]},
            swept={one.name for one in curves if one.spectrogram},
            zooms={one["name"]: one["zooms"] for one in drawn},
            pictures={name: base64.b64encode(text.encode()).decode() for name, text in pictures.items()},
            equations=[
                {"title": s.title, "lines": [(left, s.sign, right) for left, right in s.lines]} for s in equations
            ],
            library=embedded().library,
            kinds=embedded().kinds,
            completed_title=COMPLETED_TITLE,
            tables=TABLES,
            side={"title": SIDE_TITLE, "said": SIDE_SAID},
            curves=drawn,
            style=asset("report.css"),
            script=asset("painted.js") + asset("report.js"),
        )
    )


def _shown(one: Curves) -> dict[str, str]:
    """Return which channel a set of curves is of; `leading` is empty where it is not the first of its record."""
    return {
        "key": one.name,
        "trace": one.trace_name,
        "record": one.record,
        "leading": one.record if one.name == one.record else "",
        "quantity": one.quantity,
        "words": quantity_words(one.quantity),
        "unit": unit_words(one.quantity),
        "said": OUTLINED.format(column=one.trace.column_s, detail=DETAIL_S) if isinstance(one.trace, Outline) else "",
    }


def environment(package: str = "mechid.reports") -> Environment:
    """Return the environment of a package's templates; texts are escaped."""
    environment = Environment(
        loader=PackageLoader(package),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"script_json": script_json, "opacity": opacity}
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


def opacity(value: float, most: float) -> str:
    """Return the opacity of a cell's colour for a value between -`most` and `most`.

    Examples
    --------
    >>> opacity(-0.5, 1.0), opacity(200.0, 100.0)
    ('0.38', '0.75')
    """
    return f"{DARKEST * min(abs(value) / most, 1.0) if math.isfinite(value) else 0.0:.2f}"


def asset(name: str) -> str:
    """Return the text of a file beside the templates."""
    return files("mechid.reports").joinpath("templates", name).read_text(encoding="utf-8")
