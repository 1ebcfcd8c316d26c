"""The curves of the records as the page's script reads them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mechid.analysis.order_tracking import ORDERS
from mechid.ink.quantities import axis_labels, quantity_words
from mechid.reports.curves import START_S, WORST, Curves, Spectrogram
from mechid.reports.outline import Outline
from mechid.reports.packing import pack_floats, pack_integers
from mechid.reports.trace import Trace
from mechid.units import unit_words

AROUND_S, SAMPLES = 0.15, 60
"""Ranges of the buttons next to a record: half-width around its largest sample in s, number of single samples."""
LEVELS_A_DECADE = 40.0
"""Resolution of a spectrogram's amplitudes: half a decibel."""
LEAST_AMPLITUDE = 1e-9
ORDER_WORDS = {0.5: "½"}


def payload(curves: Curves, resonances: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the data of one channel of a record for the script; JSON-serialisable."""
    constant = len(curves.rate) == 1
    return {
        "name": curves.name,
        "quantity": quantity_words(curves.quantity),
        "unit": unit_words(curves.quantity),
        "labels": axis_labels(curves.quantity),
        "trace": _samples(curves.trace) if isinstance(curves.trace, Trace) else _outline(curves.trace),
        "spectrum": {
            "hz": pack_floats(curves.spectrum_hz),
            **{key: pack_floats(getattr(curves, key)) for key in ("measured", "modelled", "residual")},
        },
        "shown_hz": shown_hz(curves),
        "density": {"hz": pack_floats(curves.density_hz), "residual": pack_floats(curves.residual_density)},
        # JSON has no NaN.
        "noise_density": float(np.nan_to_num(curves.noise_density)),
        "correlation": pack_floats(curves.correlation),
        "limit": curves.limit,
        "orders": order_marks(curves) if constant else [],
        "resonances": [
            {"hz": r["frequency_hz"], "label": r["name"]} for r in resonances if math.isfinite(r["frequency_hz"])
        ],
        "rate": curves.rate.tolist(),
        "zooms": zooms(curves),
        "spectrogram": _image(curves.spectrogram) if curves.spectrogram else None,
    }


def _samples(trace: Trace) -> dict[str, Any]:
    return {
        "samples": trace.samples,
        "start_s": trace.start_s,
        "sample_rate_hz": trace.sample_rate_hz,
        "step": trace.step,
        "model": trace.model,
        "difference": trace.difference,
    }


def _outline(outline: Outline) -> dict[str, Any]:
    return {
        "samples": outline.samples,
        "start_s": outline.start_s,
        "sample_rate_hz": outline.sample_rate_hz,
        "step": outline.step,
        "outline": {name: {"numbers": one.numbers, "steps": one.steps} for name, one in outline.curves.items()},
        "stretches": [_samples(trace) for trace in outline.stretches.values()],
    }


def shown_hz(curves: Curves) -> float:
    """Return the initial upper frequency of a spectrum in Hz: 500, as on paper, or six times the step rate."""
    return float(min(max(500.0, 6.0 * curves.largest_rate), 0.5 * curves.trace.sample_rate_hz))


def order_marks(curves: Curves) -> list[dict[str, Any]]:
    """Return the frequencies in Hz of the orders of a constant step rate, and their labels."""
    return [{"hz": order * curves.largest_rate, "label": order_word(order)} for order in ORDERS if curves.largest_rate]


def order_word(order: float) -> str:
    """Return an order as it is written beside its line."""
    return ORDER_WORDS.get(order, f"{order:g}")


def zooms(curves: Curves) -> list[dict[str, Any]]:
    """Return the named stretches of a record, each with its range of record time in s."""
    base, peak = curves.base, curves.largest_s
    first, last = base.start_s, base.start_s + (base.samples - 1) / base.sample_rate_hz
    # In a short record the usual stretch would be the whole record.
    around = min(AROUND_S, 0.25 * (last - first))
    few = min(0.5 * SAMPLES / base.sample_rate_hz, around)
    stretches = {
        "whole record": (first, last),
        "start": (first, min(first + START_S, last)),
        f"largest {quantity_words(curves.quantity)}": (peak - around, peak + around),
        "single samples": (peak - few, peak + few),
    }
    if isinstance(curves.trace, Outline):
        worst = curves.trace.stretches[WORST]
        middle = worst.start_s + 0.5 * (worst.samples - 1) / worst.sample_rate_hz
        stretches |= {WORST: (middle - around, middle + around)}
    return [{"label": k, "from": max(a, first), "to": min(b, last)} for k, (a, b) in stretches.items()]


def _image(s: Spectrogram) -> dict[str, Any]:
    return {
        "columns": s.time_s.size,
        "rows": s.frequency_hz.size,
        "levels_a_decade": LEVELS_A_DECADE,
        "time_s": [float(s.time_s[0]), float(s.time_s[-1])],
        "hz": float(s.frequency_hz[-1]),
        # The logarithmic scale of a record of zeros needs an end above zero.
        "high": float(np.nanmax(s.measured)) or 1.0,
        "measured": pack_integers(_levels(s.measured)),
        "modelled": pack_integers(_levels(s.modelled)),
    }


def _levels(amplitude: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Return amplitudes in integer half decibels over one unit, row by row; NaN counts as zero."""
    # Neither NaN nor the logarithm of zero is a whole number.
    size = np.maximum(np.nan_to_num(amplitude), LEAST_AMPLITUDE)
    return np.asarray(np.rint(LEVELS_A_DECADE * np.log10(size)), dtype=np.int64).ravel()
