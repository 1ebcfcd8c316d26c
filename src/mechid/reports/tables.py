"""The tables of a fit's report, each built once for terminal, Markdown and page."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from mechid.ink.data import Data
from mechid.ink.quantities import torque_alone
from mechid.ink.table import Table
from mechid.ink.text_table import MARKDOWN, PAGE, TERMINAL, Column, OnPage, Row
from mechid.reports.side import SIDE_COLUMNS
from mechid.reports.validation import CHANNEL, RECORD, VALIDATION_LAYOUTS

PARAMETER = Column("parameter", "key", words=True, where=(TERMINAL, PAGE))
FULL_NAME = Column("parameter", "name", words=True)
SYMBOL = Column("symbol", "symbol", words=True, where=(MARKDOWN, PAGE))
ESTIMATES = (
    Column("nominal", "nominal"),
    Column("estimate", "estimate", on_page=OnPage(style="estimate")),
    Column("+- sigma", "std_error", said="± σ"),
    Column("unit", "unit", words=True, on_page=OnPage(style="word number")),
)
TRUTH = tuple(
    Column(header, key, where=(TERMINAL, PAGE)) for header, key in (("truth", "truth"), ("off", "deviation_sigmas"))
)


def _bounds(row: Row) -> Markup:
    """Return where nominal value and estimate lie between the bounds, drawn."""
    if row["place"] is None:
        return Markup("")
    marks = Markup('<i style="left: {}%"></i><i class="now" style="left: {}%"></i>')
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
ON_TERMINAL = tuple(c for c in LIMITS if TERMINAL in c.where)
NARROWER = (
    ((PARAMETER, *ESTIMATES, *TRUTH), (PARAMETER, *ON_TERMINAL)),
    ((PARAMETER, *ESTIMATES), (PARAMETER, *TRUTH, *ON_TERMINAL)),
)
KNOWN = (
    FULL_NAME,
    SYMBOL,
    Column("value", "estimate"),
    Column("unit", "unit", words=True),
    Column("meaning", "meaning", words=True, where=(PAGE,), on_page=OnPage(wide=True)),
)
PRIORS = (
    PARAMETER,
    Column("prior", "prior"),
    Column("+- sigma", "prior_sigma"),
    Column("estimate", "estimate"),
    Column("+- sigma", "std_error"),
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
ORDER = Column("order", "order")
ORDER_ERRORS = (
    Column("error %", "amplitude_error_percent", said="error, %"),
    Column("phase deg", "phase_error_deg", said="phase, deg"),
    Column("peak at", "peak_rate", said="largest at, steps/s"),
)


def parameter_table(data: Data) -> Table:
    """Return the estimated parameters; with the truth where it is known, in Markdown by their full names."""
    meanings = data.get("meanings", {})
    rows = [{**row, "meaning": meanings.get(row["name"], "")} for row in data["parameters"] if row["estimated"]]
    names = (PARAMETER, Column("parameter", "name", words=True, where=(MARKDOWN,)), SYMBOL)
    truth = TRUTH if data["has_truth"] else ()
    return Table((*names, *ESTIMATES, *truth, *LIMITS), rows, group="", narrower=NARROWER, tip="meaning")


def known_table(data: Data) -> Table:
    """Return the parameters that count as known."""
    rows = [{**row, "meaning": data["meanings"][row["name"]]} for row in data["parameters"] if not row["estimated"]]
    return Table(KNOWN, rows)


def prior_table(data: Data) -> Table:
    """Return the priors, and how sure the records alone would be."""
    return Table(PRIORS, [row for row in data["parameters"] if row["prior"]])


def followed_table(data: Data) -> Table:
    """Return how each record, or each channel where there are several, is followed."""
    alone = torque_alone(data["channels"])
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


def validation_table(rows: Sequence[Row]) -> Table:
    """Return how records are predicted, with what their residuals are made of."""
    (columns,), *narrower = VALIDATION_LAYOUTS
    return Table(columns, rows, narrower=narrower)


def stage_table(rows: Sequence[Row]) -> Table:
    """Return the stages of a search."""
    return Table(STAGES, rows)


def order_table(rows: Sequence[Row]) -> Table:
    """Return how lines at orders of the step rate are predicted, by record and channel."""
    unit = ", N m" if torque_alone(rows) else ""
    channel = () if torque_alone(rows) else CHANNEL
    return Table((RECORD, *channel, ORDER, *_sizes(unit), *ORDER_ERRORS), rows)


def order_table_of_one(rows: Sequence[Row]) -> Table:
    """Return the same of one channel of one record, whose unit stands beside it."""
    return Table((ORDER, *_sizes(""), *ORDER_ERRORS), rows)


def side_table(rows: Sequence[Row]) -> Table:
    """Return the largest lines of forces and moments beside the torque."""
    return Table(SIDE_COLUMNS, rows)


def _sizes(unit: str) -> tuple[Column, Column]:
    return Column("measured", "measured", said=f"measured{unit}"), Column(
        "modelled", "modelled", said=f"modelled{unit}"
    )
