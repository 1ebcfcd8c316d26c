"""Figures of a comparison: evidence for each fit, residuals of each record, and residual spectra."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from mechid.arrays import FloatArray
from mechid.ink.figures import STYLE, in_powers, legend_above, make_figure
from mechid.ink.palette import NOISE, series

EVIDENCE_NAME, RECORDS_NAME, SPECTRA_NAME = "comparison_evidence", "comparison_records", "comparison_spectra"
MARGIN_IN, ROW_IN = 0.9, 0.34
CRITERIA = {"bic_effective": "by effective samples", "bic": "as if white"}
NAMES_FROM = 0.24
"""Left margin as a share of the width, for names."""
MOST_SPECTRA, SPECTRUM_IN = 8, 1.7
"""Most records with drawn spectra, and the height of each in inches."""
# Small differences are close to 0, large ones span several decades.
LINEAR = 10.0
"""Limit of the linear part of the criterion axis, which is logarithmic beyond."""


def comparison_figures(data: Mapping[str, Any]) -> Iterator[tuple[str, Figure]]:
    """Yield the figures for the result of `comparison_numbers`."""
    with mpl.rc_context(STYLE), np.errstate(all="ignore"):
        yield EVIDENCE_NAME, make_figure(partial(_evidence, data), MARGIN_IN + ROW_IN * len(data["scores"]))
        yield RECORDS_NAME, make_figure(partial(_records, data), MARGIN_IN + ROW_IN * len(data["records"]))

        if data["spectra"]["records"]:
            drawn = most_different_spectra(data)
            yield SPECTRA_NAME, make_figure(partial(_spectra, data, drawn), MARGIN_IN + SPECTRUM_IN * len(drawn))


def most_different_spectra(data: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the spectra of records whose residuals differ most between the fits, in the order of the comparison."""
    residuals = {row["name"]: np.array(row["residual_rms"], dtype=np.float64) for row in data["records"]}
    spread = {name: float(np.nan_to_num(np.ptp(np.log(own)), nan=np.inf)) for name, own in residuals.items()}
    largest = sorted(data["spectra"]["records"], key=lambda one: -spread[one["name"]])[:MOST_SPECTRA]
    return [one for one in data["spectra"]["records"] if one in largest]


def criterion_differences(data: Mapping[str, Any], key: str) -> FloatArray:
    """Return the criterion of each fit minus the least of all, (hypotheses,)."""
    values = np.array([row[key] for row in data["scores"]], dtype=np.float64)
    return values - np.nanmin(values) if np.any(np.isfinite(values)) else values


def residual_ratios(data: Mapping[str, Any]) -> FloatArray:
    """Return residuals of each record relative to the first fit, (records, hypotheses)."""
    residuals = np.array([row["residual_rms"] for row in data["records"]], dtype=np.float64)
    return residuals / residuals[:, :1]


def _evidence(data: Mapping[str, Any], figure: Any) -> None:
    values = np.stack([criterion_differences(data, key) for key in CRITERIA], axis=1)
    axes = _bars(figure, data["hypotheses"], values, list(CRITERIA.values()))
    axes.set_xscale("symlog", linthresh=LINEAR)
    axes.set_xlim(0.0, max(2.0 * LINEAR, 1.5 * float(np.nanmax(values, initial=0.0))))
    axes.set_xlabel("Bayesian criterion above the least")


def _records(data: Mapping[str, Any], figure: Any) -> None:
    axes = _bars(figure, [row["name"] for row in data["records"]], residual_ratios(data), data["hypotheses"])
    axes.set_xlabel(f"residual over that of {data['hypotheses'][0]}")


def _spectra(data: Mapping[str, Any], drawn: list[dict[str, Any]], figure: Any) -> None:
    every = figure.subplots(len(drawn), 1, sharex=True, squeeze=False)[:, 0]
    for axes, record in zip(every, drawn, strict=True):
        for k, (name, rms) in enumerate(zip(data["hypotheses"], record["rms"], strict=True)):
            if rms is not None:
                axes.plot(data["spectra"]["centres_hz"], _floats(rms), color=series(k + 1), linewidth=1.2, label=name)
        axes.plot(data["spectra"]["centres_hz"], _floats(record["noise"]), "--", color=NOISE, label="noise")
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_title(record["name"], fontsize=8.0, loc="left")
        axes.set_ylabel("residual, N m")
        in_powers(axes.xaxis)
        in_powers(axes.yaxis)
    legend_above(figure, every[0], len(data["hypotheses"]) + 1)
    every[-1].set_xlabel("frequency, Hz")
    figure.subplots_adjust(hspace=0.3)


def _floats(values: list[float | None]) -> FloatArray:
    return np.array(values, dtype=np.float64)


def _bars(figure: Any, rows: list[str], values: FloatArray, names: list[str]) -> Any:
    """Draw a group of bars for each row, one per name, (rows, names); return the axes."""
    axes, height = figure.subplots(), 0.8 / len(names)
    axes.set_axisbelow(True)
    for k, name in enumerate(names):
        at = np.arange(len(rows)) + (k - 0.5 * (len(names) - 1)) * height
        axes.barh(at, np.nan_to_num(values[:, k]), height, color=series(k + 1), label=name)
    axes.set_yticks(range(len(rows)), rows)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    legend_above(figure, axes, len(names))
    figure.subplots_adjust(left=NAMES_FROM)
    return axes
