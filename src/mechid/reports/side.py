"""Rows of the forces and moments measured besides the torque: the largest lines of each component."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any

import numpy as np

from mechid.analysis.residual_emission import TRACKED
from mechid.analysis.side_components import side_lines
from mechid.analysis.validation import RecordValidation
from mechid.ink.digits import plain, with_sigma
from mechid.ink.quantities import quantity_words
from mechid.ink.text_table import Column
from mechid.units import unit_words

SIDE_TITLE = "Forces and moments beside the torque"
SIDE_SAID = (
    "The largest lines of each component, about the mounting point, at orders of the step rate (1: once a full step). "
    "The phase is that to the torque's line of the same order, where the windows of the record agree on one. All lines "
    "are in components.json, which the budget reads."
)
SHOWN = 3
"""Largest number of orders of each component, each at the rate of its largest amplitude."""
SIDE_COLUMNS = (
    Column("component", "component", words=True),
    Column("order", "order"),
    Column("at steps/s", "rate"),
    Column("record", "name", words=True),
    Column("amplitude", "amplitude"),
    Column("+- sigma", "sigma"),
    Column("unit", "unit", words=True),
    Column("phase deg", "phase"),
    Column("+- deg", "phase_sigma"),
)


def side_rows(validation: Mapping[str, RecordValidation]) -> list[dict[str, Any]]:
    """Return a row for each of the largest lines of each component; empty if no record has any."""
    lines = [line for record in validation.values() for line in _lines(record)]
    rows: list[dict[str, Any]] = []
    for component in dict.fromkeys(line["component"] for line in lines):
        own = sorted((x for x in lines if x["component"] == component), key=lambda x: float(-x["amplitude"]))
        # In ascending amplitude, the largest line of each order is entered last and stays.
        largest = {line["order"]: line for line in reversed(own)}.values()
        rows += islice(sorted(largest, key=lambda x: float(-x["amplitude"])), SHOWN)
    return [{**row, "text": _texts(row)} for row in rows]


def _lines(record: RecordValidation) -> Iterator[dict[str, Any]]:
    """Yield the lines of a record that exceed the noise."""
    for at in record.side:
        lines = side_lines(at)
        for k, j in np.argwhere(lines.heard).tolist():
            known = bool(lines.known[k, j])
            yield {
                "name": record.name,
                "component": record.components[j],
                "order": TRACKED[k],
                "rate": at.rate,
                "windows": at.windows,
                "amplitude": float(lines.amplitude[k, j]),
                "sigma": float(lines.sigma[k, j]),
                "torque_amplitude_Nm": float(at.amplitude[k, 0]),
                "phase_deg": float(np.degrees(lines.phase[k, j])) if known else None,
                "phase_sigma_deg": float(np.degrees(lines.phase_sigma[k, j])) if known else None,
            }


def _texts(row: Mapping[str, Any]) -> dict[str, str]:
    amplitude, sigma = with_sigma(row["amplitude"], row["sigma"])
    known = row["phase_deg"] is not None
    phase, phase_sigma = with_sigma(row["phase_deg"], row["phase_sigma_deg"]) if known else ("not known", "")
    return {
        "component": quantity_words(row["component"]),
        "unit": unit_words(row["component"]),
        "order": plain(row["order"], 4),
        "rate": plain(row["rate"], 4),
        "amplitude": amplitude,
        "sigma": sigma,
        "phase": phase,
        "phase_sigma": phase_sigma,
    }
