"""The figures on paper, made with Matplotlib: vector text, palette of Okabe and Ito, two columns wide.

Text stays text in the SVG, so that it can be searched and edited; line styles and widths differ as the colours do.
"""

from __future__ import annotations

import gc
import io
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator
from numpy.typing import NDArray

from mechid.analysis.order_tracking import ORDERS
from mechid.report.curves import Curves
from mechid.report.payload import order_marks, shown_hz
from mechid.report.quantities import (
    AMPLITUDE,
    CORRELATION,
    DENSITY,
    FREQUENCY,
    LAG,
    RESIDUAL,
    TIME,
    TORQUE,
    axis_labels,
    quantity_words,
)
from mechid.writing import whole

FloatArray = NDArray[np.float64]
FOLDER_NAME = "figures"
WIDTH_IN = 6.9
"""Inches: both columns of a paper."""
LEFT_IN, RIGHT_IN, BELOW_IN, ABOVE_IN, BAR_IN = 0.68, 0.18, 0.42, 0.28, 0.58
"""Margins; measured out by a layout engine they would take as long again as the drawing."""
DOTS_AN_INCH = 200
MEASURED, MODELLED, RESIDUAL_COLOUR, NOISE, MARK = "#56B4E9", "#D55E00", "#4D4D4D", "#009E73", "#CC79A7"
STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["Helvetica", "Arial", "Liberation Sans", "DejaVu Sans"],
    "font.size": 8.0,
    "axes.labelsize": 8.0,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "grid.linewidth": 0.4,
    "grid.alpha": 0.4,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "lines.linewidth": 0.8,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "svg.fonttype": "none",
    "svg.hashsalt": "mechid",
    "path.simplify": True,
}
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
Drawing = Callable[[Any], None]


def paper_figures(data: Mapping[str, Any], curves: Sequence[Curves]) -> Iterator[tuple[str, Figure]]:
    """Yield the figures with their names: of each channel of each record, of the correlation, of the information.

    Parameters
    ----------
    data : mapping
        As `report_contents` makes it.
    curves : sequence of Curves
    """
    for name, height, draw in _drawings(data, curves):
        with mpl.rc_context(STYLE), np.errstate(all="ignore"):
            figure = made(draw, height)
        yield name, figure


def write_figures(figures: Iterable[tuple[str, Figure]], folder: Path) -> dict[str, str]:
    """Write each figure as SVG and PNG as it comes, and return the SVG texts by name.

    Each file is written beside its place and renamed.

    Raises
    ------
    OSError
        The folder cannot be written to.
    """
    folder.mkdir(parents=True, exist_ok=True)
    texts = {}
    gc.freeze()  # only what the figures make is looked through below
    for name, figure in figures:
        texts[name] = _written(name, figure, folder)
        figure.clear()
        gc.collect()  # parts of a figure refer to one another; uncollected, those of a report are 50 MB
    gc.unfreeze()
    return texts


def _written(name: str, figure: Figure, folder: Path) -> str:
    """Write a figure as SVG and PNG, and return the SVG's text."""
    svg, png = io.BytesIO(), io.BytesIO()
    with mpl.rc_context(STYLE):
        figure.savefig(svg, format="svg", metadata={"Date": None, "Title": name, "Creator": "mechid"})
        figure.savefig(png, format="png", dpi=DOTS_AN_INCH, pil_kwargs={"compress_level": 4})
    for suffix, content in (("svg", svg), ("png", png)):
        with whole(folder / f"{name}.{suffix}") as beside:
            beside.write_bytes(content.getvalue())
    return svg.getvalue().decode("utf-8")


def made(draw: Drawing, height: float) -> Figure:
    """Return a figure of a height in inches, two columns wide, with what `draw` draws on it."""
    figure = Figure(figsize=(WIDTH_IN, height))
    FigureCanvasAgg(figure)
    figure.subplots_adjust(
        left=LEFT_IN / WIDTH_IN, right=1.0 - RIGHT_IN / WIDTH_IN, bottom=BELOW_IN / height, top=1.0 - ABOVE_IN / height
    )
    draw(figure)
    return figure


def _drawings(data: Mapping[str, Any], curves: Sequence[Curves]) -> Iterator[tuple[str, float, Drawing]]:
    for one in curves:
        yield one.trace_name, 3.6, partial(_torque, one)
        yield f"{one.name}_spectrum", 2.4, partial(_spectrum, one, data["resonances"])
        yield f"{one.name}_residual", 2.2, partial(_residual, one)
        if one.spectrogram:
            yield f"{one.name}_spectrogram", 3.4, partial(_spectrogram, one, data["resonances"])
    correlation, information = data["correlation"], data["information"]
    if correlation["names"]:
        size = 0.27 * len(correlation["names"]) + 1.0
        yield "correlation", size, partial(_matrix, correlation, "matrix", correlation["symbols"], "correlation")
    if information:
        size = 0.2 * len(information["parameters"]) + 1.0
        yield (
            "information",
            size,
            partial(_matrix, information, "share_percent", information["records"], "share of the information, %"),
        )
    if information and len(information["channels"]) > 1:
        names = [quantity_words(quantity) for quantity in information["channels"]]
        draw = partial(_matrix, information, "channel_share_percent", names, "share of the information, %")
        yield "information_by_channel", 0.2 * len(information["parameters"]) + 1.0, draw


def _torque(one: Curves, figure: Any) -> None:
    """Draw measured and modelled torque, or what else it is, over the whole record, its start, and the residual."""
    labels = axis_labels(one.quantity)
    axes = figure.subplot_mosaic([["whole", "start"], ["residual", "start residual"]], height_ratios=[2, 1],
                                 width_ratios=[3, 2], gridspec_kw={"hspace": 0.08, "wspace": 0.2})  # fmt: skip
    for (torque, residual), lines in ((("whole", "residual"), one.whole), (("start", "start residual"), one.start)):
        over_time(axes[torque], lines.measured, MEASURED, 1.3, "measured")
        over_time(axes[torque], lines.modelled, MODELLED, 0.7, "modelled")
        over_time(axes[residual], lines.residual, RESIDUAL_COLOUR, 0.5, "residual")
        axes[residual].sharex(axes[torque])
        axes[torque].tick_params(labelbottom=False)
        axes[residual].set_xlabel(TIME)
        axes[torque].margins(x=0.0)
    axes["whole"].set_ylabel(labels[TORQUE])
    axes["residual"].set_ylabel(labels[RESIDUAL])
    _legend(figure, axes["whole"], 2)


def _legend(figure: Any, axes: Any, columns: int) -> None:
    """Write the legend above the axes, at the right."""
    place = {"loc": "upper right", "bbox_to_anchor": (1.0 - RIGHT_IN / WIDTH_IN, 1.0), "borderaxespad": 0.3}
    figure.legend(*axes.get_legend_handles_labels(), ncols=columns, **place)


def over_time(axes: Any, points: FloatArray, colour: str, width: float, label: str) -> None:
    """Draw times in s and samples, (2, n)."""
    axes.plot(*points, color=colour, linewidth=width, label=label)


def _spectrum(one: Curves, resonances: Sequence[Mapping[str, Any]], figure: Any) -> None:
    axes, shown = figure.subplots(), shown_hz(one)
    kept = one.spectrum_hz <= shown
    for y, colour, width, label in (
        (one.residual, RESIDUAL_COLOUR, 0.5, "residual"),
        (one.measured, MEASURED, 1.4, "measured"),
        (one.modelled, MODELLED, 0.7, "modelled"),
    ):
        axes.semilogy(one.spectrum_hz[kept], y[kept], color=colour, linewidth=width, label=label)
    marks = (
        order_marks(one) if len(one.rate) == 1 else [{"hz": r["frequency_hz"], "label": r["name"]} for r in resonances]
    )
    for mark in marks:
        if mark["hz"] <= shown:
            axes.axvline(mark["hz"], color=MARK, linewidth=0.7, linestyle="--", zorder=0)
            axes.annotate(mark["label"], (mark["hz"], 1.0), xycoords=("data", "axes fraction"), xytext=(2, -2),
                          textcoords="offset points", va="top", color=MARK, fontsize=7)  # fmt: skip
    floor = _quantile(one.residual[kept], 0.05) / 2.0
    if floor > 0.0:
        axes.set_ylim(bottom=floor)
    axes.set(xlabel=FREQUENCY, ylabel=axis_labels(one.quantity)[AMPLITUDE], xlim=(0.0, shown))
    in_powers(axes.yaxis)
    _legend(figure, axes, 3)


def _residual(one: Curves, figure: Any) -> None:
    left, right = figure.subplots(1, 2, width_ratios=[3, 2], gridspec_kw={"wspace": 0.28})
    left.loglog(one.density_hz, one.residual_density, color=RESIDUAL_COLOUR, linewidth=0.5, label="residual")
    left.axhline(one.noise_density, color=NOISE, linewidth=1.0, linestyle="--", label="noise floor")
    low, high = _quantile(one.residual_density, 0.0), _quantile(one.residual_density, 1.0)
    if low > 0.0:
        left.set_ylim(min(low, one.noise_density) / 3.0, max(high, one.noise_density) * 3.0)
    left.set(xlabel=FREQUENCY, ylabel=axis_labels(one.quantity)[DENSITY])
    in_powers(left.xaxis)
    in_powers(left.yaxis)
    left.legend(loc="upper left", ncols=2)
    lags = np.arange(1, one.correlation.size + 1)
    right.vlines(lags, 0.0, one.correlation, color=RESIDUAL_COLOUR, linewidth=1.0)
    for sign in (-1.0, 1.0):
        right.axhline(sign * one.limit, color=NOISE, linewidth=0.8, linestyle="--")
    right.set(xlabel=LAG, ylabel=CORRELATION)


def _spectrogram(one: Curves, resonances: Sequence[Mapping[str, Any]], figure: Any) -> None:
    s = one.spectrogram
    assert s is not None
    top = min(2.5 * one.largest_rate, float(s.frequency_hz[-1]))
    high = float(np.nanmax(s.measured)) or 1.0
    figure.subplots_adjust(right=1.0 - BAR_IN / WIDTH_IN)
    axes = figure.subplots(1, 2, sharex=True, sharey=True, gridspec_kw={"wspace": 0.06})
    image = None
    for ax, values, word in zip(axes, (s.measured, s.modelled), ("measured", "modelled"), strict=True):
        image = ax.pcolormesh(s.time_s, s.frequency_hz, np.nan_to_num(values), norm=LogNorm(high / 3000.0, high),
                              cmap="cividis", rasterized=True, shading="nearest")  # fmt: skip
        for order in ORDERS:
            ax.plot(one.rate[:, 0], order * np.abs(one.rate[:, 1]), "w--", linewidth=0.5, alpha=0.6)
        for r in resonances:
            if r["frequency_hz"] <= top:
                ax.axhline(r["frequency_hz"], color="#FF8FC7", linewidth=0.8, linestyle=":")
        ax.set(xlabel=TIME, ylim=(0.0, top), xlim=(s.time_s[0], s.time_s[-1]), title=word)
        ax.title.set_fontsize(8.0)
        ax.grid(visible=False)
    axes[0].set_ylabel(FREQUENCY)
    bar = figure.colorbar(image, ax=list(axes), label=axis_labels(one.quantity)[AMPLITUDE], pad=0.02, fraction=0.06)
    in_powers(bar.ax.yaxis)


def _matrix(data: Mapping[str, Any], key: str, columns: Sequence[str], label: str, figure: Any) -> None:
    """Draw a matrix of numbers as coloured cells, rows named by parameters."""
    rows, values = data.get("names") or data["parameters"], np.array(data[key], dtype=np.float64)
    signed = key == "matrix"
    figure.subplots_adjust(
        left=1.8 / WIDTH_IN, right=1.0 - BAR_IN / WIDTH_IN, bottom=0.75 / figure.get_figheight(), top=0.97
    )
    axes = figure.subplots()
    limits: Any = (
        {"vmin": -1.0, "vmax": 1.0, "cmap": "PuOr"} if signed else {"vmin": 0.0, "vmax": 100.0, "cmap": "Blues"}
    )
    image = axes.imshow(values, aspect="auto", **limits)
    for (i, j), value in np.ndenumerate(values):
        text = data["text"][i][j] if signed else data["text"][key][i][j]
        dark = abs(value) > (0.7 if signed else 60.0)
        axes.text(j, i, text, ha="center", va="center", fontsize=5.5, color="white" if dark else "black")
    axes.set_xticks(range(len(columns)), columns, rotation=45, ha="right")
    axes.set_yticks(range(len(rows)), rows)
    axes.grid(visible=False)
    figure.colorbar(image, ax=axes, label=label, pad=0.02, fraction=0.05)


def in_powers(axis: Any) -> None:
    """Label a logarithmic axis with powers of ten, as plain text: a formula's layout takes a hundred times longer."""
    axis.set_major_formatter(FuncFormatter(power_of_ten))
    axis.set_minor_locator(NullLocator())


def power_of_ten(value: float, _: int | None = None) -> str:
    """Return the nearest power of ten as text.

    Examples
    --------
    >>> power_of_ten(0.001), power_of_ten(10.0)
    ('10⁻³', '10¹')
    """
    return "10" + str(round(math.log10(value))).translate(SUPERSCRIPT) if value > 0.0 else ""


def _quantile(values: FloatArray, share: float) -> float:
    finite = values[np.isfinite(values)]
    return float(np.quantile(finite, share)) if finite.size else math.nan
