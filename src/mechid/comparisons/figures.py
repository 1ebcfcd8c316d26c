"""The figures of a comparison: the evidence for each fit, what each leaves of each record, and where in frequency."""

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
"""Share of the width from which the picture begins: names stand left of it."""
MOST_SPECTRA, SPECTRUM_IN = 8, 1.7
"""Records whose spectra are drawn, and the height of each, inches."""
LINEAR = 10.0
"""Up to which the axis of the criterion is linear, logarithmic beyond."""


def comparison_figures(data: Mapping[str, Any]) -> Iterator[tuple[str, Figure]]:
    """Yield the figures of what `comparison_numbers` made."""
    with mpl.rc_context(STYLE), np.errstate(all="ignore"):
        yield EVIDENCE_NAME, make_figure(partial(_evidence, data), MARGIN_IN + ROW_IN * len(data["scores"]))
        yield RECORDS_NAME, make_figure(partial(_records, data), MARGIN_IN + ROW_IN * len(data["records"]))

        if data["spectra"]["records"]:
            drawn = apart_most(data)
            yield SPECTRA_NAME, make_figure(partial(_spectra, data, drawn), MARGIN_IN + SPECTRUM_IN * len(drawn))


def apart_most(data: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the spectra of the records whose residuals differ most between the fits, in the comparison's order."""
    residuals = {row["name"]: np.array(row["residual_rms"], dtype=np.float64) for row in data["records"]}
    spread = {name: float(np.nan_to_num(np.ptp(np.log(own)), nan=np.inf)) for name, own in residuals.items()}
    largest = sorted(data["spectra"]["records"], key=lambda one: -spread[one["name"]])[:MOST_SPECTRA]
    return [one for one in data["spectra"]["records"] if one in largest]


def above_least(data: Mapping[str, Any], key: str) -> FloatArray:
    """Return each fit's criterion less the least of all, (hypotheses,)."""
    values = np.array([row[key] for row in data["scores"]], dtype=np.float64)
    return values - np.nanmin(values) if np.any(np.isfinite(values)) else values


def over_first(data: Mapping[str, Any]) -> FloatArray:
    """Return the residual of each record by each fit over that of the first one, (records, hypotheses)."""
    residuals = np.array([row["residual_rms"] for row in data["records"]], dtype=np.float64)
    return residuals / residuals[:, :1]


def _evidence(data: Mapping[str, Any], figure: Any) -> None:
    values = np.stack([above_least(data, key) for key in CRITERIA], axis=1)
    axes = _bars(figure, data["hypotheses"], values, list(CRITERIA.values()))
    axes.set_xscale("symlog", linthresh=LINEAR)
    axes.set_xlim(0.0, max(2.0 * LINEAR, 1.5 * float(np.nanmax(values, initial=0.0))))
    axes.set_xlabel("Bayesian criterion above the least")


def _records(data: Mapping[str, Any], figure: Any) -> None:
    axes = _bars(figure, [row["name"] for row in data["records"]], over_first(data), data["hypotheses"])
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
    """Draw a group of bars for each row, one for each name, (rows, names), and return the axes."""
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
