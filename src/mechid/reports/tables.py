"""The tables of a fit's report, each built once for terminal, Markdown and page."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from markupsafe import Markup

from mechid.ink.data import Data
from mechid.ink.quantities import has_only_torque
from mechid.ink.table import Table
from mechid.ink.text_table import DOCX, MARKDOWN, PAGE, TERMINAL, Column, OnPage, Row
from mechid.reports.side import SIDE_COLUMNS
from mechid.validations.tables import CHANNEL, RECORD

PARAMETER = Column("parameter", "key", words=True, where=(TERMINAL, PAGE))
NAMES = (PARAMETER, Column("parameter", "name", words=True, where=(MARKDOWN, DOCX)))
FULL_NAME = Column("parameter", "name", words=True)
SYMBOL = Column("symbol", "symbol", words=True, where=(MARKDOWN, PAGE))
ESTIMATES = (
    Column("nominal", "nominal"),
    Column("estimate", "estimate", on_page=OnPage(style="estimate")),
    Column("+- sigma", "std_error", said="± σ"),
    Column("unit", "unit", words=True, on_page=OnPage(style="word number")),
)
TRUTH = (Column("truth", "truth"), Column("off", "deviation_sigmas"))


def _bounds(row: Row) -> Markup:
    """Return a bar that shows nominal value and estimate between the bounds."""
    if row["place"] is None:
        return Markup("")
    marks = Markup('<i style="left: {}%"></i><i class="now" style="left: {}%"></i>')
    # The bar is hidden from screen readers, which read the bounds in the columns beside it.
    bar = Markup('<span class="bounds" aria-hidden="true">{}</span>')
    return bar.format(marks.format(row["nominal_place"], row["place"]))


def _link(row: Row) -> Markup:
    """Return a record's name that leads to its part of the page."""
    return Markup('<a href="#record-{0}">{0}</a>').format(row["name"])


LIMITS = (
    Column("min", "min"),
    Column("", "place", where=(PAGE,), on_page=OnPage(ink=_bounds, drops=True, spoken="position within bounds")),
    Column("max", "max", on_page=OnPage(style="word number")),
    Column(
        "status",
        "status",
        words=True,
        on_page=OnPage(style=lambda row: f"word status-{row['status']}", tip=lambda row: str(row["reason"])),
    ),
)
NARROWER = (
    ((PARAMETER, *ESTIMATES, *TRUTH), (PARAMETER, *LIMITS)),
    ((PARAMETER, *ESTIMATES), (PARAMETER, *TRUTH, *LIMITS)),
)
KNOWN = (
    FULL_NAME,
    SYMBOL,
    Column("value", "estimate"),
    Column("unit", "unit", words=True),
    Column("meaning", "meaning", words=True, where=(PAGE, DOCX), on_page=OnPage(wide=True)),
)
PRIORS = (
    *NAMES,
    Column("prior", "prior"),
    Column("+- sigma", "prior_sigma", said="± σ"),
    Column("estimate", "estimate"),
    Column("+- sigma", "std_error", said="± σ"),
    Column("records alone", "without_prior"),
)
FOLLOWED = (
    Column("use", "use", words=True),
    Column("samples", "samples"),
    Column("fit %", "fit_percent"),
    Column("residual", "residual_rms"),
    Column("noise", "noise_sigma"),
    Column("followed %", "followed_percent"),
)
LINEAR = (Column("offset", "offset"), Column("drift /s", "drift"))
STAGES = (
    Column("stage", "name", words=True),
    Column("records", "records"),
    Column("record s", "record_s", said="record time, s"),
    Column("free", "free"),
    Column("cost", "cost", said="cost, σ²"),
    Column("evaluations", "evaluations"),
    Column("took s", "seconds", said="took, s"),
    Column("note", "note", words=True, where=(PAGE,), on_page=OnPage(wide=True)),
)


def parameter_table(data: Data) -> Table:
    """Return the estimated parameters; with the truth where it is known, in Markdown by their full names."""
    meanings = data.get("meanings", {})
    rows = [{**row, "meaning": meanings.get(row["name"], "")} for row in data["parameters"] if row["estimated"]]
    truth = TRUTH if data["has_truth"] else ()
    return Table((*NAMES, SYMBOL, *ESTIMATES, *truth, *LIMITS), rows, group="", narrower=NARROWER, tip="meaning")


def known_table(data: Data) -> Table:
    """Return the parameters that count as known."""
    rows = [{**row, "meaning": data["meanings"][row["name"]]} for row in data["parameters"] if not row["estimated"]]
    return Table(KNOWN, rows)


def prior_table(data: Data) -> Table:
    """Return the priors, and how sure the records alone would be."""
    return Table(PRIORS, [row for row in data["parameters"] if row["prior"]], group="")


def followed_table(data: Data) -> Table:
    """Return how each record, or each channel where there are several, is followed."""
    alone = has_only_torque(data["channels"])
    first = (RECORD,) if alone else (RECORD, *CHANNEL)
    narrower = (((*first, *FOLLOWED), (*first, *LINEAR)),)
    return Table((*first, *FOLLOWED, *LINEAR), data["records" if alone else "channels"], narrower=narrower)


def record_table(data: Data) -> Table:
    """Return how each channel of each record is predicted over its whole length."""
    rows = data["record_table"]
    labels = [label for label, _ in rows[0]["cells"]] if rows else []
    first = Column("record", "name", words=True, on_page=OnPage(ink=_link)), Column("use", "use", words=True)
    short = [OnPage(header=label.removeprefix("Ljung-Box ")) for label in labels]
    columns = (*first, *(Column(label, str(k), on_page=short[k]) for k, label in enumerate(labels)))
    return Table(columns, [{**r, "text": {str(k): text for k, (_, text) in enumerate(r["cells"])}} for r in rows])


def stage_table(rows: Sequence[Row]) -> Table:
    """Return the stages of a search."""
    return Table(STAGES, rows)


def side_table(rows: Sequence[Row]) -> Table:
    """Return the largest lines of forces and moments beside the torque."""
    return Table(SIDE_COLUMNS, rows)


def matrix(
    corner: str,
    names: Sequence[str],
    columns: Sequence[str],
    texts: Sequence[Sequence[str]],
    shades: Sequence[Sequence[float]] | None = None,
) -> Table:
    """Return a text for each pair of names and columns; on a page the darker the larger its shade, -1 to 1."""
    shown = [Column(column, str(k), on_page=OnPage(heat=partial(_shade, k))) for k, column in enumerate(columns)]
    rows = [
        {"name": name, "shades": shades[i] if shades else None, "text": {str(k): text for k, text in enumerate(cells)}}
        for i, (name, cells) in enumerate(zip(names, texts, strict=True))
    ]
    return Table((Column(corner, "name", words=True), *shown), rows, style="matrix")


def _shade(k: int, row: Row) -> float:
    return float(row["shades"][k]) if row["shades"] else 0.0
