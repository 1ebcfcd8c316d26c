"""Tables of a fleet: campaigns, parameters over the units and by unit, tests."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from markupsafe import Markup

from mechid.ink.data import Data
from mechid.ink.document import IN_DOCUMENTS
from mechid.ink.table import Table
from mechid.ink.text_table import MARKDOWN, PAGE, TERMINAL, Column, OnPage, Row

IN_TEXT = (TERMINAL, MARKDOWN)
STRONGEST = 6.0
"""Spreads from the mean at which a cell has its strongest colour."""


def _label_link(row: Row) -> str:
    """Return a campaign's label, as a link to its report if there is one."""
    if row["link"] is None:
        return str(row["label"])
    return Markup('<a href="{}">{}</a>').format(row["link"], row["label"])


def _with_unit(row: Row) -> Markup:
    unit = row["text"]["unit"]
    more = Markup(' <span class="soft">{}</span>').format(unit) if unit else ""
    return Markup("{}{}").format(row["key"], more)


def _below(text: str, more: str) -> Markup:
    """Return a text with further text in small letters below."""
    small = Markup('<span class="range">{}</span>').format(more) if more else Markup("")
    return Markup("<span>{}{}</span>").format(text, small)


def _mean(row: Row) -> Markup:
    """Return the mean with its error and position on a trend, or the reason for a missing mean."""
    text = row["text"]
    if row["lacking"]:
        return _below(text["mean"], f"{text['lacking']} term: see by unit")
    return _below(f"{text['mean']} ± {text['std_error']}" if text["std_error"] else text["mean"], text["along"])


def _spread(row: Row) -> Markup:
    ends = row["text"]["spread95"]
    return _below(row["text"]["spread"], "" if row["mean"] is None else ends)


def _found_style(key: str) -> OnPage:
    return OnPage(style=lambda row: "word found" if row[key] else "word")


PARAMETER = Column("parameter", "key", words=True, where=(TERMINAL, PAGE), on_page=OnPage(ink=_with_unit))
NAME = Column("parameter", "name", words=True, where=(MARKDOWN,))
FLEET = (
    Column("units", "units"),
    Column("mean", "mean", where=IN_TEXT),
    Column("+- sigma", "std_error", said="± σ", where=IN_TEXT),
    Column("mean ± σ", "mean", where=(PAGE,), on_page=OnPage(ink=_mean, style="estimate")),
    Column("unit", "unit", words=True, where=IN_TEXT),
)
SPREAD = (
    Column("spread", "spread", where=IN_TEXT),
    Column("95 %", "spread95", where=IN_TEXT),
    Column("spread (95 %)", "spread", where=(PAGE,), on_page=OnPage(ink=_spread)),
    Column("a further unit", "next95", where=IN_DOCUMENTS),
    Column("", "differs", words=True, said="differs", on_page=_found_style("differs")),
    Column("q", "q", where=IN_DOCUMENTS),
    Column("stands off", "outliers", words=True, style="yellow", on_page=_found_style("outliers")),
    Column("", "lacking", words=True, where=IN_TEXT),
)
TESTS = {
    "trends": (
        Column("over", "covariate", words=True),
        Column("slope ± σ", "slope"),
        Column("95 %", "range"),
        Column("of", "of", words=True),
    ),
    "groups": (Column("unit", "unit", words=True), Column("means ± σ", "means", words=True)),
    "mean_changes": (
        Column("from, to", "states", words=True),
        Column("units", "units"),
        Column("mean ± σ", "mean"),
        Column("95 %", "range"),
        Column("spread", "spread"),
    ),
    "changes": (
        Column("unit", "unit", words=True),
        Column("from, to", "states", words=True),
        Column("change ± σ", "difference"),
        Column("in its errors", "sigmas"),
    ),
}
"""Columns of tests by kind, between the parameter and q."""


def campaign_table(data: Data) -> Table:
    """Return the campaigns with unit, grade and origin of the estimate."""
    campaigns = data["campaigns"]
    needed = [key for key in ("group", "state") if any(c[key] for c in campaigns)]
    if any(c["unit"] != c["label"] for c in campaigns):
        needed = ["unit", *needed]
    return Table(
        (
            Column("campaign", "label", words=True, on_page=OnPage(ink=_label_link)),
            *(Column(key, key, words=True) for key in needed),
            *(Column(name, f"covariate_{k}", where=IN_DOCUMENTS) for k, name in enumerate(data["covariates"])),
            Column("grade", "grade", words=True, on_page=OnPage(style=_grade_of(data["failed"]))),
            Column("", "how_words", words=True, where=(TERMINAL,)),
            Column("estimate", "how", words=True, where=IN_DOCUMENTS),
            Column("took s", "seconds", said="took, s"),
            Column("reason", "reason", words=True, where=IN_DOCUMENTS, on_page=OnPage(style="word reason", wide=True)),
        ),
        campaigns,
    )


def _grade_of(failed: Sequence[str]) -> Callable[[Row], str]:
    return lambda row: "word failed" if row["label"] in failed else "word"


def parameter_table(data: Data) -> Table:
    """Return mean and spread of each parameter over the units."""
    narrower = (((PARAMETER, *FLEET), (PARAMETER, *SPREAD)),)
    return Table((PARAMETER, NAME, *FLEET, *SPREAD), data["parameters"], group="", narrower=narrower)


def unit_table(data: Data) -> Table:
    """Return each parameter's value by campaign; the colour shows the distance from the mean."""
    columns = (Column(c["label"], f"cell_{k}", on_page=_on_page_of(k)) for k, c in enumerate(data["campaigns"]))
    rows = [p["by_unit"] for p in data["parameters"]]
    return Table((Column("parameter", "name", words=True), *columns), rows, style="units")


def _on_page_of(k: int) -> OnPage:
    def cell(row: Row) -> Data:
        found: Data = row["cells"][k]
        return found

    return OnPage(
        ink=lambda row: _with_error(cell(row)),
        style=lambda row: str(cell(row)["mark"]),
        tip=lambda row: str(cell(row)["why"]),
        heat=lambda row: cell(row)["off"] / STRONGEST,
    )


def _with_error(cell: Data) -> Markup:
    error = f"± {cell['error']}" if cell["error"] else ""
    return _below(cell["text"], " ".join(filter(None, (error, cell["said"]))))


def tests_table(kind: str, rows: Sequence[Row]) -> Table:
    """Return the table of one kind of tests in `TESTS`."""
    return Table((Column("parameter", "name", words=True), *TESTS[kind], Column("q", "q")), rows)
