"""Drawings of the figures of a record on paper, and of matrices.

A drawing consists of a function and plain data, so that a separate process can make it without loading the rest of
mechid.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from mechid.arrays import FloatArray
from mechid.ink.figures import BAR_IN, STYLE, WIDTH_IN, in_powers, legend_above, make_figure, over_time
from mechid.ink.palette import MARK, MARK_OVER, MEASURED, MODELLED, NOISE
from mechid.ink.palette import RESIDUAL as RESIDUAL_COLOUR
from mechid.ink.quantities import (
    AMPLITUDE,
    CORRELATION,
    DENSITY,
    FREQUENCY,
    LAG,
    RESIDUAL,
    TIME,
    TORQUE,
    axis_labels,
)
from mechid.ink.sheet import Sheet

Span = Sequence[FloatArray]
"""Measured, modelled and residual curves: times in s and samples, (2, n) each; or amplitudes of a spectrum, (n,)."""


def draw(sheet: Sheet) -> Figure:
    """Draw the figure of a sheet."""
    drawing = DRAWINGS[sheet.drawing]
    with mpl.rc_context(STYLE), np.errstate(all="ignore"):
        return make_figure(lambda figure: drawing(figure, **sheet.data), sheet.height_in)


def torque(figure: Any, *, quantity: str, whole: Span, start: Span) -> None:
    """Draw measurement and model of a quantity over the whole record and its start, and the residual."""
    labels = axis_labels(quantity)
    axes = figure.subplot_mosaic(
        [["whole", "start"], ["residual", "start residual"]],
        height_ratios=[2, 1],
        width_ratios=[3, 2],
        gridspec_kw={"hspace": 0.08, "wspace": 0.2},
    )
    for (above, below), lines in ((("whole", "residual"), whole), (("start", "start residual"), start)):
        over_time(axes[above], lines[0], MEASURED, 1.3, "measured")
        over_time(axes[above], lines[1], MODELLED, 0.7, "modelled")
        over_time(axes[below], lines[2], RESIDUAL_COLOUR, 0.5, "residual")
        axes[below].sharex(axes[above])
        axes[above].tick_params(labelbottom=False)
        axes[below].set_xlabel(TIME)
        axes[above].margins(x=0.0)
    axes["whole"].set_ylabel(labels[TORQUE])
    axes["residual"].set_ylabel(labels[RESIDUAL])
    legend_above(figure, axes["whole"], 2)


def spectrum(
    figure: Any, *, quantity: str, hz: FloatArray, amplitudes: Span, marks: Sequence[tuple[float, str]], shown_hz: float
) -> None:
    """Draw amplitude spectra up to a frequency; each mark is a frequency in Hz and its label."""
    axes, kept = figure.subplots(), hz <= shown_hz
    measured, modelled, left = amplitudes
    for y, colour, width, label in (
        (left, RESIDUAL_COLOUR, 0.5, "residual"),
        (measured, MEASURED, 1.4, "measured"),
        (modelled, MODELLED, 0.7, "modelled"),
    ):
        axes.semilogy(hz[kept], y[kept], color=colour, linewidth=width, label=label)
    for at, label in marks:
        if at <= shown_hz:
            axes.axvline(at, color=MARK, linewidth=0.7, linestyle="--", zorder=0)
            axes.annotate(
                label,
                (at, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(2, -2),
                textcoords="offset points",
                va="top",
                color=MARK,
                fontsize=7,
            )
    # Single bins near zero would take most decades of the axis.
    floor = _quantile(left[kept], 0.05) / 2.0
    if floor > 0.0:
        axes.set_ylim(bottom=floor)
    axes.set(xlabel=FREQUENCY, ylabel=axis_labels(quantity)[AMPLITUDE], xlim=(0.0, shown_hz))
    in_powers(axes.yaxis)
    legend_above(figure, axes, 3)


def residual(
    figure: Any,
    *,
    quantity: str,
    hz: FloatArray,
    density: FloatArray,
    noise_density: float,
    correlation: FloatArray,
    limit: float,
) -> None:
    """Draw the density of the residual and of the noise floor, and the autocorrelation of the residual from lag 1."""
    left, right = figure.subplots(1, 2, width_ratios=[3, 2], gridspec_kw={"wspace": 0.28})
    left.loglog(hz, density, color=RESIDUAL_COLOUR, linewidth=0.5, label="residual")
    left.axhline(noise_density, color=NOISE, linewidth=1.0, linestyle="--", label="noise floor")
    low, high = _quantile(density, 0.0), _quantile(density, 1.0)
    if low > 0.0:
        left.set_ylim(min(low, noise_density) / 3.0, max(high, noise_density) * 3.0)
    left.set(xlabel=FREQUENCY, ylabel=axis_labels(quantity)[DENSITY])
    in_powers(left.xaxis)
    in_powers(left.yaxis)
    left.legend(loc="upper left", ncols=2)
    lags = np.arange(1, correlation.size + 1)
    right.vlines(lags, 0.0, correlation, color=RESIDUAL_COLOUR, linewidth=1.0)
    for sign in (-1.0, 1.0):
        right.axhline(sign * limit, color=NOISE, linewidth=0.8, linestyle="--")
    right.set(xlabel=LAG, ylabel=CORRELATION)


def spectrogram(
    figure: Any,
    *,
    quantity: str,
    time_s: FloatArray,
    hz: FloatArray,
    amplitudes: Sequence[FloatArray],
    orders: Sequence[tuple[FloatArray, FloatArray]],
    resonances_hz: Sequence[float],
    top_hz: float,
) -> None:
    """Draw measured and modelled amplitude over time and frequency, with lines of orders and resonances."""
    # The logarithmic scale of a record of zeros needs an end above zero.
    high = float(np.nanmax(amplitudes[0])) or 1.0
    figure.subplots_adjust(right=1.0 - BAR_IN / WIDTH_IN)
    axes = figure.subplots(1, 2, sharex=True, sharey=True, gridspec_kw={"wspace": 0.06})
    image = None
    for ax, values, word in zip(axes, amplitudes, ("measured", "modelled"), strict=True):
        image = ax.pcolormesh(
            time_s,
            hz,
            np.nan_to_num(values),
            norm=LogNorm(high / 3000.0, high),
            cmap="cividis",
            # As vectors, each cell would be an element of the SVG.
            rasterized=True,
            shading="nearest",
        )
        for at_s, order_hz in orders:
            ax.plot(at_s, order_hz, "w--", linewidth=0.5, alpha=0.6)
        for at in resonances_hz:
            if at <= top_hz:
                ax.axhline(at, color=MARK_OVER, linewidth=0.8, linestyle=":")
        ax.set(xlabel=TIME, ylim=(0.0, top_hz), xlim=(time_s[0], time_s[-1]), title=word)
        ax.title.set_fontsize(8.0)
        ax.grid(visible=False)
    axes[0].set_ylabel(FREQUENCY)
    bar = figure.colorbar(image, ax=list(axes), label=axis_labels(quantity)[AMPLITUDE], pad=0.02, fraction=0.06)
    in_powers(bar.ax.yaxis)


def matrix(
    figure: Any,
    *,
    rows: Sequence[str],
    columns: Sequence[str],
    values: FloatArray,
    texts: Sequence[Sequence[str]],
    label: str,
    signed: bool,
) -> None:
    """Draw a matrix of shares in percent, or of values from -1 to 1, as coloured cells with texts."""
    figure.subplots_adjust(
        left=1.8 / WIDTH_IN, right=1.0 - BAR_IN / WIDTH_IN, bottom=0.75 / figure.get_figheight(), top=0.97
    )
    axes = figure.subplots()
    limits: Any = (
        {"vmin": -1.0, "vmax": 1.0, "cmap": "PuOr"} if signed else {"vmin": 0.0, "vmax": 100.0, "cmap": "Blues"}
    )
    image = axes.imshow(values, aspect="auto", **limits)
    for (i, j), value in np.ndenumerate(values):
        # White text is legible only on the dark ends of the colour maps.
        dark = abs(value) > (0.7 if signed else 60.0)
        axes.text(j, i, texts[i][j], ha="center", va="center", fontsize=5.5, color="white" if dark else "black")
    axes.set_xticks(range(len(columns)), columns, rotation=45, ha="right")
    axes.set_yticks(range(len(rows)), rows)
    axes.grid(visible=False)
    figure.colorbar(image, ax=axes, label=label, pad=0.02, fraction=0.05)


def _quantile(values: FloatArray, share: float) -> float:
    finite = values[np.isfinite(values)]
    return float(np.quantile(finite, share)) if finite.size else math.nan


DRAWINGS: Mapping[str, Callable[..., None]] = {
    "torque": torque,
    "spectrum": spectrum,
    "residual": residual,
    "spectrogram": spectrogram,
    "matrix": matrix,
}
