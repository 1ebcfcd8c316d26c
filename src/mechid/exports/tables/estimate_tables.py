"""Tables of a fit: parameters, covariance, records and provenance."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from mechid.exports.handover import Handover
from mechid.exports.tables.table import Column, Table, numbers, texts
from mechid.identification.result.parameter_estimate import ParameterEstimate

SAME_UNIT = "as the parameter"
OWN_UNIT = "unit of the channel"


def estimate_tables(handover: Handover) -> tuple[Table, ...]:
    """Return the tables of a fit."""
    return (
        _parameters(handover.fit.parameters),
        _covariance(handover),
        _correlation(handover),
        _records(handover),
    )


def provenance_table(handover: Handover, words: Sequence[str]) -> Table:
    """Return the table of origin, reliability and remarks."""
    rows = [*_flat(handover.provenance), *(("words", line) for line in words)]
    return Table(
        "provenance",
        (
            texts("entry", "what it is", [key for key, _ in rows]),
            texts("value", "what it says", [value for _, value in rows]),
        ),
    )


def _parameters(parameters: Mapping[str, ParameterEstimate]) -> Table:
    rows = list(parameters.values())

    def of(key: str) -> list[Any]:
        return [getattr(row, key) for row in rows]

    ends = [row.ci95 or (None, None) for row in rows]
    return Table(
        "parameters",
        (
            texts("parameter", "dotted name in the mechanism file", list(parameters)),
            texts("symbol", "in the equations", _text(of("symbol"))),
            numbers("value", SAME_UNIT, "estimate, or the value that was known", of("value")),
            texts("unit", "of value, errors, interval and bounds", _text(of("unit"))),
            texts("status", "free, known, tied to another, frozen, or at a bound", _text(of("status"))),
            numbers("std_error", SAME_UNIT, "standard error, also where the model lacks something", of("std_error")),
            numbers("std_error_noise", SAME_UNIT, "the same by noise of any colour alone", of("std_error_noise")),
            numbers("ci95_low", SAME_UNIT, "lower end of the 95 % interval", [low for low, _ in ends]),
            numbers("ci95_high", SAME_UNIT, "upper end of the 95 % interval", [high for _, high in ends]),
            numbers("start", SAME_UNIT, "where the search began", of("start")),
            numbers("min", SAME_UNIT, "lower bound", of("min")),
            numbers("max", SAME_UNIT, "upper bound", of("max")),
            texts("reason", "why it has this status", _text(of("reason"))),
            texts("added", "yes: the fit added it to the mechanism", ["yes" if row.added else "" for row in rows]),
        ),
    )


def _covariance(handover: Handover) -> Table:
    words = "covariance with it, by std_error"
    columns = zip(handover.names, handover.covariance.T, strict=True)
    return _matrix("covariance", handover, [Column(n, "product of the units", words, c) for n, c in columns])


def _correlation(handover: Handover) -> Table:
    sigma = np.sqrt(np.diag(handover.covariance))
    matrix = handover.covariance / np.outer(sigma, sigma)
    columns = zip(handover.names, matrix.T, strict=True)
    return _matrix("correlation", handover, [Column(n, "1", "correlation with it", c) for n, c in columns])


def _matrix(name: str, handover: Handover, columns: Sequence[Column]) -> Table:
    return Table(name, (texts("parameter", "of the row", list(handover.names)), *columns))


def _records(handover: Handover) -> Table:
    records, summaries = handover.fit.records, handover.residuals.summaries if handover.residuals else {}
    rows = list(records.values())

    def of(key: str) -> list[Any]:
        return [getattr(row, key) for row in rows]

    commands = [summaries[name].command if name in summaries else {} for name in records]
    units = [next((channel.unit for channel in row.channels.values()), "") for row in rows]
    return Table(
        "records",
        (
            texts("record", "name in the campaign file", list(records)),
            texts("use", "estimate or validate", _text(of("use"))),
            texts("stepping", "as it was driven", [str(c.get("stepping", "")) for c in commands]),
            numbers("microsteps", "1", "steps in a full step", [c.get("microsteps") for c in commands]),
            numbers("samples", "1", "samples used", of("samples")),
            texts("unit", "of residual, noise, offset and drift", units),
            numbers("fit_percent", "%", "100 (1 - |residual| / |measured - mean|)", of("fit_percent")),
            numbers("residual_rms", OWN_UNIT, "RMS of measured less model", of("residual_rms")),
            numbers("noise_sigma", OWN_UNIT, "noise of a sample", of("noise_sigma")),
            numbers("offset", OWN_UNIT, "that was removed, at the first sample", of("offset")),
            numbers("drift", f"{OWN_UNIT} per s", "that was removed", of("drift")),
        ),
    )


def _text(values: Sequence[Any]) -> list[str]:
    return ["" if value is None else str(value) for value in values]


def _flat(content: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, str]]:
    """Yield the entries of nested mappings with dotted keys."""
    for key, value in content.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", str(value)
