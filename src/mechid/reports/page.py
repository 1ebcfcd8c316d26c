"""The report of a fit as one HTML file that needs nothing beside it."""

from __future__ import annotations

import base64
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from mechid.diagnoses.effects_shown import own_table
from mechid.diagnoses.path import COMPLETED_TITLE, path_table
from mechid.ink.quantities import quantity_words
from mechid.ink.table import Table
from mechid.ink.template import asset, environment, page_style
from mechid.kernel.equation_text import Section
from mechid.reports import tables
from mechid.reports.curves import Curves
from mechid.reports.embedded import embedded
from mechid.reports.outline import DETAIL_S, Outline
from mechid.reports.payload import payload
from mechid.reports.side import SIDE_SAID, SIDE_TITLE
from mechid.units import unit_words

MOST_PICTURES = 200
"""Figures on paper that a page holds at most; a page of more names their files. Those of 500 records are 160 MB."""
OUTLINED = (
    "A long record: the figure shows the least and the largest sample of every {column:.3g} s of it, and every sample "
    "of {detail:.3g} s around what the buttons name."
)
TABLES: Mapping[str, Callable[[Any], Table]] = {
    "orders": tables.order_table_of_one,
    "known": tables.known_table,
    "own": own_table,
    "parameters": tables.parameter_table,
    "path": path_table,
    "records": tables.record_table,
    "side": tables.side_table,
    "stages": tables.stage_table,
}


def report_page(
    data: Mapping[str, Any], curves: Sequence[Curves], pictures: Mapping[str, Path], equations: Sequence[Section]
) -> Iterator[str]:
    """Return the page in pieces, made as they are asked for: that of many records is large.

    Parameters
    ----------
    data : mapping
        As `report_contents` makes it.
    curves : sequence of Curves
        Of the records, in their order.
    pictures : mapping of str to Path
        The SVG files of the figures on paper, by name; they are shown in print and where no script runs.
    equations : sequence of Section
        In MathML.
    """
    drawn = [payload(one, data["resonances"]) for one in curves]
    return (
        environment()
        .get_template("report.html")
        .generate(
            data={**data, "curves": [_shown(one) for one in curves]},
            swept={one.name for one in curves if one.spectrogram},
            zooms={one["name"]: one["zooms"] for one in drawn},
            pictures=pictures,
            holds_pictures=len(pictures) <= MOST_PICTURES,
            in_base64=_in_base64,
            equations=[
                {"title": s.title, "lines": [(left, s.sign, right) for left, right in s.lines]} for s in equations
            ],
            library=embedded().library,
            kinds=embedded().kinds,
            completed_title=COMPLETED_TITLE,
            tables=TABLES,
            side={"title": SIDE_TITLE, "said": SIDE_SAID},
            curves=drawn,
            style=page_style(),
            script=asset("painted.js") + asset("report.js"),
        )
    )


def _in_base64(file: Path) -> str:
    return base64.b64encode(file.read_bytes()).decode()


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
