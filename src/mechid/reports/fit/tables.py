"""The tables that terminal, Markdown and page of a report share, each with its columns."""

from __future__ import annotations

from collections.abc import Sequence

from mechid.reports.fit.path import PATH_COLUMNS
from mechid.reports.fit.side import SIDE_COLUMNS
from mechid.reports.fit.validation import CHANNEL, RECORD
from mechid.reports.quantities import torque_alone
from mechid.reports.table import Table
from mechid.reports.text_table import Column, Row

NAME = Column("name", "name", words=True)
VALUE = (
    Column("value", "value"),
    Column("std error", "std_error", said="± σ"),
    Column("unit", "unit", words=True),
)
MEANING = Column("meaning", "meaning", words=True, wide=True)
STAGES = (
    Column("stage", "name", words=True),
    Column("records", "records"),
    Column("record s", "record_s", said="record time, s"),
    Column("free", "free"),
    Column("cost", "cost", said="cost, σ²"),
    Column("evaluations", "evaluations"),
    Column("took s", "seconds", said="took, s"),
    Column("note", "note", words=True, on_page=True, wide=True),
)
ORDER = Column("order", "order")
ORDER_ERRORS = (
    Column("error %", "amplitude_error_percent", said="error, %"),
    Column("phase deg", "phase_error_deg", said="phase, deg"),
    Column("peak at", "peak_rate", said="largest at, steps/s"),
)


def stage_table(rows: Sequence[Row]) -> Table:
    """Return the stages of a search."""
    return Table(STAGES, rows)


def own_table(rows: Sequence[Row]) -> Table:
    """Return parameters that no table of the files has, with their values."""
    return Table((NAME, *VALUE), rows)


def beside_table(rows: Sequence[Row]) -> Table:
    """Return the parameters of terms beside the mechanism, under what each term is."""
    named = [{**row, "table": f"{row['words']} ({row['term']})"} for row in rows]
    return Table((NAME, *VALUE, MEANING), named, group="term")


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


def path_table(rows: Sequence[Row]) -> Table:
    """Return the steps of a search for what a mechanism lacks."""
    return Table(PATH_COLUMNS, rows)


def _sizes(unit: str) -> tuple[Column, Column]:
    return Column("measured", "measured", said=f"measured{unit}"), Column(
        "modelled", "modelled", said=f"modelled{unit}"
    )
