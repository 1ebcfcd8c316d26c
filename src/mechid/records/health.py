"""Health checks of a channel: finite values, variation, and no clipping."""

from __future__ import annotations

import numpy as np

from mechid.records.record import Channel
from mechid.records.spec import Role
from mechid.records.table import Table
from mechid.signal.clipping import CLIPPED_RUN, clipped_runs
from mechid.signal.moments import extremes
from mechid.signal.series import Series
from mechid.signal.stored_series import pieces_of

ENCODED = ("rotor_angle", "output_angle", "position")
LEAST_EXTREME, LARGEST_EXTREME = 1e-20, 1e20
"""Plausible range of a channel's largest magnitude in SI units; beyond it, sums of squares may overflow."""
CLIPPED_TIMES = 2
"""Least number of clipped stretches for a warning; a single one may be a mechanism at rest."""


def refuse_not_finite(table: Table, data: Series, label: str, first: int = 0, if_missing: str = "") -> None:
    """Raise RecordError for the first NaN or infinity of a series whose first row in the file is `first`."""
    for part in pieces_of(data):
        values = data[part]
        rows = np.flatnonzero(~np.isfinite(values))
        if rows.size:
            odd = values[rows[0]]
            message = f"{label}: {odd} is not a finite number{if_missing if np.isnan(odd) else ''}"
            raise table.error(message, first + part.start + int(rows[0]))


def channel_warnings(table: Table, channel: Channel, doubt: str | None = None) -> list[str]:
    """Return warnings about a channel; `doubt` states why another column may be meant.

    Raises
    ------
    RecordError
        An output is constant, or its values are implausible.
    """
    low, high = extremes(channel.data)
    largest = max(abs(low), abs(high))
    if largest > LARGEST_EXTREME or 0.0 < largest < LEAST_EXTREME:
        raise table.error(
            f'"{channel.column}": {channel.quantity} is {largest:.3g} {channel.unit} at most, no measured size; '
            "look at the column, its unit and the number format"
        )
    if low == high:
        message = f'"{channel.column}": {channel.quantity} is constant at {low:.9g} {channel.unit}'
        if channel.role is Role.OUTPUT:
            raise table.error(f"{message}: the channel is dead{f'; {doubt}' if doubt else ''}")
        return [str(table.error(message))]
    # A driver's voltage stays at its limits by design, and a mechanism rests where it was driven to.
    if channel.role is Role.INPUT or channel.quantity.startswith("voltage") or channel.quantity in ENCODED:
        return []
    return _clipping_warnings(table, channel)


def _clipping_warnings(table: Table, channel: Channel) -> list[str]:
    runs = clipped_runs(channel.data)
    if len(runs) < CLIPPED_TIMES:
        return []
    message = (
        f'"{channel.column}": {channel.quantity} stays at its extreme for {CLIPPED_RUN} samples or more '
        f"{len(runs)} times, first here: clipped?"
    )
    return [str(table.error(message, runs[0][0]))]
