"""Names of quantities: words, axis labels and keys of channels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from mechid.units import unit_words

TORQUE, RESIDUAL = "torque, N m", "residual, N m"
AMPLITUDE, DENSITY = "amplitude, N m", "residual density, N m/√Hz"
TIME, FREQUENCY, LAG, CORRELATION = "time, s", "frequency, Hz", "lag, samples", "autocorrelation"


def quantity_words(quantity: str) -> str:
    """Return a quantity in words.

    Examples
    --------
    >>> quantity_words("output_angle")
    'output angle'
    """
    return quantity.replace("_", " ")


def axis_labels(quantity: str) -> dict[str, str]:
    """Return the axis labels of a quantity, by the corresponding labels of the torque.

    Examples
    --------
    >>> axis_labels("position")["residual density, N m/√Hz"]
    'residual density, m/√Hz'
    """
    unit = unit_words(quantity)
    return {
        TORQUE: f"{quantity_words(quantity)}, {unit}",
        RESIDUAL: f"residual, {unit}",
        AMPLITUDE: f"amplitude, {unit}",
        DENSITY: f"residual density, {unit}/√Hz",
    }


def has_only_torque(rows: Iterable[Mapping[str, Any]]) -> bool:
    """Return whether all rows belong to torque channels, so that the unit can be in the header."""
    return all(row["quantity"] == "torque" for row in rows)


def channel_key(record: str, quantity: str, leading: str) -> str:
    """Return the name of a channel's figures, which is that of the record for its leading channel.

    Examples
    --------
    >>> channel_key("full_46", "torque", "torque"), channel_key("full_46", "output_angle", "torque")
    ('full_46', 'full_46.output_angle')
    """
    return record if quantity == leading else f"{record}.{quantity}"
