"""Details of the report: dependence, information by record, resonances, how records were driven."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mechid.analysis.information import Information
from mechid.campaign import Campaign
from mechid.campaign.campaign import parameters_of
from mechid.command.words import command_words
from mechid.identification.result.finished_fit import record_as_fitted
from mechid.identification.result.fit import Fit
from mechid.ink.digits import digits
from mechid.reports.use import use_word
from mechid.simulation.resonances import Resonance


def correlation_data(fit: Fit) -> dict[str, Any]:
    """Return the correlation of the free parameters: names, symbols, the matrix and its text."""
    matrix = fit.correlation.tolist()
    return {
        "names": list(fit.correlation_names),
        "symbols": [symbol_of(fit, name) for name in fit.correlation_names],
        "matrix": matrix,
        "text": [[f"{value:+.2f}" if math.isfinite(value) else "-" for value in row] for row in matrix],
    }


def information_data(information: Information | None, fit: Fit, campaign: Campaign) -> dict[str, Any] | None:
    """Return the information of each record and channel on each parameter: shares in percent, factors on errors."""
    if information is None:
        return None
    percent, by_channel = (100.0 * information.share).tolist(), (100.0 * information.channel_share).tolist()
    return {
        "parameters": list(information.parameters),
        "symbols": [symbol_of(fit, name) for name in information.parameters],
        "records": list(information.records),
        "duration_s": [_duration(campaign, name) for name in information.records],
        "share_percent": percent,
        "without": information.without.tolist(),
        "repeated": information.repeated.tolist(),
        "channels": list(information.channels),
        "channel_share_percent": by_channel,
        "without_channel": information.without_channel.tolist(),
        "text": {
            "share_percent": [[_percent(value) for value in row] for row in percent],
            "without": [[digits(value, 3) for value in row] for row in information.without.tolist()],
            "repeated": [[digits(value, 3) for value in row] for row in information.repeated.tolist()],
            "channel_share_percent": [[_percent(value) for value in row] for row in by_channel],
            "without_channel": [[digits(value, 3) for value in row] for row in information.without_channel.tolist()],
        },
    }


def resonance_data(found: Sequence[Resonance]) -> list[dict[str, Any]]:
    """Return a row for each resonance."""
    return [
        {"name": r.name, "frequency_hz": r.frequency_hz, "text": {"frequency_hz": digits(r.frequency_hz, 4)}}
        for r in found
    ]


def driven_data(campaign: Campaign, fit: Fit) -> dict[str, Any]:
    """Return the command, the reinterpretations and the file of each record, by name."""
    return {
        record.name: {
            "use": use_word(record.use, left_out=fit.records[record.name].reading.left_out),
            "command": command_words(record.command),
            # The use has a field of its own.
            "taken": {key: v for key, v in fit.records[record.name].reading.to_dict().items() if key != "use"},
            "file": record.spec.path,
            "duration_s": _duration(campaign, record.name),
        }
        for record in (record_as_fitted(one, fit) for one in campaign.records)
        if record.data is not None
    }


def meaning_data(campaign: Campaign, fit: Fit) -> dict[str, str]:
    """Return the meaning of each parameter by name, including per-record parameters that the fit added."""
    records = tuple(record_as_fitted(record, fit) for record in campaign.records)
    return {name: q.declaration.meaning for name, q in parameters_of(fit.mechanism, records).items()}


def symbol_of(fit: Fit, name: str) -> str:
    """Return the symbol of a parameter; that of a per-record parameter includes the record."""
    symbol = fit.parameters[name].symbol
    return f"{symbol} {name.split('.')[1]}" if name.startswith("record.") else symbol


def worst_pair(correlation: Mapping[str, Any]) -> tuple[str, str, float] | None:
    """Return the two parameters with the largest correlation, and its value; None for fewer than two.

    Examples
    --------
    >>> worst_pair({"names": ["a", "b", "c"], "matrix": [[1, 0.2, -0.9], [0.2, 1, 0], [-0.9, 0, 1]]})
    ('a', 'c', -0.9)
    """
    names = correlation["names"]
    if len(names) < 2:
        return None
    # An undetermined correlation is NaN, and argmax would return it as the largest.
    matrix = np.nan_to_num(np.array(correlation["matrix"], dtype=np.float64))
    # The upper triangle holds each pair once, without the diagonal of ones.
    i, j = np.unravel_index(int(np.argmax(np.abs(np.triu(matrix, 1)))), matrix.shape)
    return names[int(i)], names[int(j)], float(matrix[i, j])


def _percent(value: float) -> str:
    """Format a share with two digits; less than a tenth of a percent is 0.

    Examples
    --------
    >>> _percent(98.7), _percent(1.26), _percent(0.03)
    ('99', '1.3', '0')
    """
    return "0" if value < 0.1 else f"{value:.1f}" if value < 9.95 else f"{value:.0f}"


def _duration(campaign: Campaign, name: str) -> float:
    data = campaign.record(name).data
    return data.duration_s if data is not None else math.nan
