"""Quantities in words: axis labels, and how a channel of a record is called."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from mechid.units import unit_words

TORQUE, RESIDUAL = "torque, N m", "residual, N m"
AMPLITUDE, DENSITY = "amplitude, N m", "residual density, N m/√Hz"
TIME, FREQUENCY, LAG, CORRELATION = "time, s", "frequency, Hz", "lag, samples", "autocorrelation"


def quantity_words(quantity: str) -> str:
    """Return a quantity as it is written in a sentence.

    Examples
    --------
    >>> quantity_words("output_angle")
    'output angle'
    """
    return quantity.replace("_", " ")


def axis_labels(quantity: str) -> dict[str, str]:
    """Return the label of each axis for a quantity, by its label for the torque.

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


def torque_alone(rows: Iterable[Mapping[str, Any]]) -> bool:
    """Tell whether rows of channels are all of torques, so that their units stand in the header."""
    return all(row["quantity"] == "torque" for row in rows)


def channel_key(record: str, quantity: str, leading: str) -> str:
    """Return what a channel's figures are called: the record's name alone for its leading channel.

    Examples
    --------
    >>> channel_key("full_46", "torque", "torque"), channel_key("full_46", "output_angle", "torque")
    ('full_46', 'full_46.output_angle')
    """
    return record if quantity == leading else f"{record}.{quantity}"
