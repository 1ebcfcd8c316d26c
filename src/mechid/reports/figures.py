"""Sheets of a report: each channel of each record, the correlation, and the information."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from mechid.analysis.order_tracking import ORDERS
from mechid.ink.quantities import quantity_words
from mechid.ink.sheet import Sheet
from mechid.reports.curves import Curves, Lines, Spectrogram
from mechid.reports.payload import order_marks, shown_hz

Resonances = Sequence[Mapping[str, Any]]
SHARE = "share of the information, %"


def channel_sheets(one: Curves, resonances: Resonances) -> Iterator[Sheet]:
    """Yield the sheets of a channel of a record.

    Parameters
    ----------
    one : Curves
    resonances : sequence of mapping
        As the report's dict has them.
    """
    quantity = {"quantity": one.quantity}
    yield Sheet(one.trace_name, 3.6, "torque", {**quantity, "whole": _span(one.whole), "start": _span(one.start)})
    spectrum = {
        "hz": one.spectrum_hz,
        "amplitudes": (one.measured, one.modelled, one.residual),
        "marks": _marks(one, resonances),
        "shown_hz": shown_hz(one),
    }
    yield Sheet(f"{one.name}_spectrum", 2.4, "spectrum", quantity | spectrum)
    residual = {
        "hz": one.density_hz,
        "density": one.residual_density,
        "noise_density": one.noise_density,
        "correlation": one.correlation,
        "limit": one.limit,
    }
    yield Sheet(f"{one.name}_residual", 2.2, "residual", quantity | residual)
    if one.spectrogram:
        swept = _spectrogram(one, one.spectrogram, resonances)
        yield Sheet(f"{one.name}_spectrogram", 3.4, "spectrogram", quantity | swept)


def matrix_sheets(data: Mapping[str, Any]) -> Iterator[Sheet]:
    """Yield the sheets of the matrices in the report's dict."""
    correlation, information = data["correlation"], data["information"]
    if correlation["names"]:
        names, symbols = correlation["names"], correlation["symbols"]
        yield _matrix("correlation", names, symbols, correlation["matrix"], correlation["text"], "correlation")
    if information:
        yield _shares("information", information, "share_percent", information["records"])
    # With a single channel every share is 100 %.
    if information and len(information["channels"]) > 1:
        names = [quantity_words(quantity) for quantity in information["channels"]]
        yield _shares("information_by_channel", information, "channel_share_percent", names)


def _span(lines: Lines) -> tuple[Any, Any, Any]:
    return lines.measured, lines.modelled, lines.residual


def _marks(one: Curves, resonances: Resonances) -> list[tuple[float, str]]:
    """Return frequencies in Hz and labels: orders for a constant rate, resonances for a varying one."""
    if len(one.rate) == 1:
        return [(mark["hz"], mark["label"]) for mark in order_marks(one)]
    return [(r["frequency_hz"], r["name"]) for r in resonances]


def _spectrogram(one: Curves, s: Spectrogram, resonances: Resonances) -> dict[str, Any]:
    times, rates = one.rate[:, 0], np.abs(one.rate[:, 1])
    return {
        "time_s": s.time_s,
        "hz": s.frequency_hz,
        "amplitudes": (s.measured, s.modelled),
        "orders": [(times, order * rates) for order in ORDERS],
        "resonances_hz": [r["frequency_hz"] for r in resonances],
        "top_hz": min(2.5 * one.largest_rate, float(s.frequency_hz[-1])),
    }


def _shares(name: str, information: Mapping[str, Any], key: str, columns: Sequence[str]) -> Sheet:
    return _matrix(name, information["parameters"], columns, information[key], information["text"][key], SHARE)


def _matrix(name: str, rows: Sequence[str], columns: Sequence[str], values: Any, texts: Any, label: str) -> Sheet:
    signed = name == "correlation"
    data = {
        "rows": list(rows),
        "columns": list(columns),
        "values": np.array(values, dtype=np.float64),
        "texts": texts,
        "label": label,
        "signed": signed,
    }
    return Sheet(name, (0.27 if signed else 0.2) * len(rows) + 1.0, "matrix", data)
