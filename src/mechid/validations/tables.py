"""Tables of predicted records."""

from __future__ import annotations

from collections.abc import Sequence

from mechid.ink.quantities import has_only_torque
from mechid.ink.table import Table
from mechid.ink.text_table import Column, Row

RECORD = Column("record", "name", words=True)
CHANNEL = (Column("channel", "quantity", words=True), Column("unit", "unit", words=True))
AGREEMENT = (Column("fit %", "fit_percent"), Column("residual", "residual_rms"))
THEIL = (
    Column("Theil", "theil"),
    Column("bias", "bias"),
    Column("variance", "variance"),
    Column("covariance", "covariance"),
)
WHITENESS = (Column("Ljung-Box p", "p_value"), Column("largest rho", "largest"), Column("effective", "effective"))
NARROWER = (((RECORD, *CHANNEL, *AGREEMENT, *THEIL), (RECORD, *CHANNEL, *WHITENESS)),)
ORDER = Column("order", "order")
ORDER_ERRORS = (
    Column("error %", "amplitude_error_percent", said="error, %"),
    Column("phase deg", "phase_error_deg", said="phase, deg"),
    Column("peak at", "peak_rate", said="largest at, steps/s"),
)


def validation_table(rows: Sequence[Row]) -> Table:
    """Return the table of predictions, with the composition of the residuals."""
    return Table((RECORD, *CHANNEL, *AGREEMENT, *THEIL, *WHITENESS), rows, narrower=NARROWER)


def order_table(rows: Sequence[Row]) -> Table:
    """Return the table of lines at orders of the step rate, by record and channel."""
    unit = ", N m" if has_only_torque(rows) else ""
    channel = () if has_only_torque(rows) else CHANNEL
    return Table((RECORD, *channel, ORDER, *_sizes(unit), *ORDER_ERRORS), rows)


def order_table_of_one(rows: Sequence[Row]) -> Table:
    """Return the table of lines of one channel, whose unit is shown next to it."""
    return Table((ORDER, *_sizes(""), *ORDER_ERRORS), rows)


def _sizes(unit: str) -> tuple[Column, Column]:
    return Column("measured", "measured", said=f"measured{unit}"), Column(
        "modelled", "modelled", said=f"modelled{unit}"
    )
