"""Figures of a budget, drawn with Matplotlib in the report's style from the plain data of its numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from mechid.budgets.mode_figures import RATE, course, line_of_sight, number_array, over_rate
from mechid.budgets.prediction_figures import draw_shares_of_limit, predicts
from mechid.budgets.texts import mode_key
from mechid.ink.data import Data
from mechid.ink.figures import BAR_IN, STYLE, WIDTH_IN, Drawing, in_powers, legend_above, make_figure
from mechid.ink.palette import GRID, INK, LIMIT, MARK, MODELLED, ORDER, series
from mechid.ink.quantities import FREQUENCY

TORQUE = "torque amplitude, N m"
DECADES = 4.0
"""Decades of amplitude that a map shows."""
RAYS = (0.5, 1.0, 2.0, 4.0, 8.0)
"""Orders drawn in a Campbell diagram."""
SPECTRA, SEEN = 30, 0.02
"""Largest number of spectra of a waterfall; share of the largest line above which a line extends its frequency axis."""
SHOWN_SHARES, LEAST_SHARE = 7, 0.01
SMALL: Any = {"handlelength": 1.4, "columnspacing": 1.2, "fontsize": 7.0}
"""Style of a legend of many entries."""
NAME_IN = 2.5
"""Width of the names next to bars, in."""


def figure_name(kind: str) -> str:
    """Return the name of a figure's files.

    Examples
    --------
    >>> figure_name("shares")
    'budget_shares'
    """
    return f"budget_{kind}"


def emission_figure(number: int) -> str:
    """Return the kind of the figure of an emission requirement, counted from 0."""
    return f"emission_{number + 1}"


def budget_figures(data: Data) -> Iterator[tuple[str, Figure]]:
    """Yield the figures of the numbers of `budget_numbers`, with their names."""
    for kind, height, draw in _drawings(data):
        with mpl.rc_context(STYLE), np.errstate(all="ignore"):
            yield figure_name(kind), make_figure(draw, height)


def _drawings(data: Data) -> Iterator[tuple[str, float, Drawing]]:
    rows = len(data["requirements"])
    if rows:
        yield "requirements", 0.32 * rows + 1.0, partial(_requirements, data)
        yield "shares", 0.32 * rows + 1.35, partial(_shares, data)
    for k, one in enumerate(data["emission_requirements"]):
        if predicts(one):
            yield emission_figure(k), 2.6, partial(draw_shares_of_limit, one["direction"], one, ())
    for k, mode in enumerate(data["modes"]):
        key = mode_key(k, mode["name"])
        if mode["kind"] == "profile":
            yield f"{key}_course", 4.2, partial(course, data, mode)
            continue
        if len(mode["rates"]) > 1:
            yield f"{key}_map", 3.2, partial(_map, mode)
            yield f"{key}_campbell", 3.6, partial(_campbell, data, mode)
            yield f"{key}_waterfall", 3.6, partial(_waterfall, mode)
            yield f"{key}_rates", 2.1 + 1.9 * bool(rows), partial(over_rate, data, mode)
        yield f"{key}_envelope", 2.4, partial(_envelope, mode)
        yield f"{key}_line_of_sight", 5.4, partial(line_of_sight, data, mode)
    if is_gain_known(data):
        yield "coupling", 2.4, partial(_draw_coupling, data)


def is_gain_known(data: Data) -> bool:
    """Return whether the criterion of one-way coupling is known at any frequency."""
    return bool(np.isfinite(number_array(data["coupling"]["loop_gain"])).any())


def _label(r: Data) -> str:
    return f"{r['requirement']}\n{r['mode']}"


def _named_rows(figure: Any, rows: Sequence[Data]) -> Any:
    figure.subplots_adjust(left=NAME_IN / WIDTH_IN)
    axes = figure.subplots()
    axes.set_yticks(range(len(rows)), [_label(r) for r in rows], fontsize=6.5)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.grid(axis="y", visible=False)
    return axes


def _requirements(data: Data, figure: Any) -> None:
    """Draw the deciding level relative to its limit with its 95 % band, the ECSS sum, and the one-way level."""
    rows = data["requirements"]
    axes = _named_rows(figure, rows)
    axes.axvline(1.0, color=LIMIT, linewidth=1.4, label="limit")
    for k, r in enumerate(rows):
        decided, ecss = r["decided"], r["ecss_summation_rad"] / r["limit_rad"]
        shown = np.array([1.0 - decided["margin"], *(1.0 - m for m in decided["margin95"])])
        axes.barh(k, shown[0], height=0.5, color=series(0), label=_label_once(axes, "level that decides"))
        axes.plot(shown[1:], [k, k], color=INK, linewidth=1.6, label=_label_once(axes, "95 % band"))
        axes.plot(ecss, k, "D", color=series(1), markersize=4, label=_label_once(axes, "ECSS sum, one-way"))
        if decided["coupling"] == "two-way":
            axes.plot(
                1.0 - r["margin"],
                k,
                "|",
                color=series(2),
                markersize=9,
                markeredgewidth=1.4,
                label=_label_once(axes, "one-way, does not decide"),
            )
    largest = max(max(1.0 - r["decided"]["margin95"][0], r["ecss_summation_rad"] / r["limit_rad"]) for r in rows)
    # One level far above its limit would shrink all others to nothing on a linear axis.
    if largest > 4.0:
        axes.set_xscale("log")
        axes.set_xlim(left=min(0.05, *(0.5 - 0.5 * r["decided"]["margin"] for r in rows)))
    axes.set_xlabel("share of the limit")
    legend_above(figure, axes, 6, **SMALL)


def _label_once(axes: Any, words: str) -> str | None:
    """Return a label, or None if the legend already has it."""
    return None if words in axes.get_legend_handles_labels()[1] else words


def _shares(data: Data, figure: Any) -> None:
    """Draw the contributions to the band of each margin: shares of the variance, negative ones at the left."""
    rows = data["requirements"]
    figure.subplots_adjust(top=1.0 - 0.6 / figure.get_figheight())
    axes = _named_rows(figure, rows)
    weight: dict[str, float] = {}
    for r in rows:
        for name, share in r["variance_shares"].items():
            weight[name] = max(weight.get(name, 0.0), abs(share))
    seen = [name for name in weight if weight[name] >= LEAST_SHARE]
    shown = sorted(seen, key=lambda name: -weight[name])[:SHOWN_SHARES]
    for k, r in enumerate(rows):
        # Correlated parameters may have negative shares: bars stack separately on both sides of zero.
        ends = {True: 0.0, False: 0.0}
        others = sum(s for name, s in r["variance_shares"].items() if name not in shown)
        parts = [*((name, r["variance_shares"].get(name, 0.0)) for name in shown), ("all others", others)]
        for j, (name, share) in enumerate(parts):
            axes.barh(
                k,
                100.0 * share,
                left=ends[share >= 0.0],
                height=0.55,
                color=series(j),
                label=name if k == 0 else None,
                edgecolor="white",
                linewidth=0.3,
            )
            ends[share >= 0.0] += 100.0 * share
    axes.use_sticky_edges = False
    axes.set_xlabel("share in the variance of the level, %")
    legend_above(figure, axes, 4, **SMALL)


def _map(mode: Data, figure: Any) -> None:
    """Draw the speed-harmonic map: torque amplitude over rate and order."""
    orders, amplitude = number_array(mode["map"]["orders"]), number_array(mode["map"]["torque_amplitude_Nm"])
    # Orders off the grid of halves occur only at rates whose motion repeats after several periods: they leave gaps.
    on_half_grid = 2.0 * orders % 1.0 == 0.0
    orders, amplitude = orders[on_half_grid], amplitude[:, on_half_grid]
    most = float(np.nanmax(amplitude)) or 1.0
    shown = max(int(np.searchsorted(orders, 16.0, side="right")), 2)
    figure.subplots_adjust(right=1.0 - BAR_IN / WIDTH_IN)
    axes = figure.subplots()
    image = axes.pcolormesh(
        number_array(mode["rates"]),
        orders[:shown],
        amplitude[:, :shown].T,
        shading="nearest",
        norm=LogNorm(most * 10.0**-DECADES, most),
        cmap="cividis",
        rasterized=True,
    )
    axes.grid(visible=False)
    axes.set(xlabel=RATE, ylabel="order (lines a full step)")
    in_powers(figure.colorbar(image, ax=axes, label=TORQUE, pad=0.02, fraction=0.05).ax.yaxis)


def _campbell(data: Data, mode: Data, figure: Any) -> None:
    """Draw torque lines by size over rate and frequency, orders as rays, modes as horizontals, and crossings."""
    rates, orders = number_array(mode["rates"]), number_array(mode["map"]["orders"])
    amplitude = number_array(mode["map"]["torque_amplitude_Nm"])
    top = 1.4 * max([m["frequency_hz"] for m in data["named_modes"]] + [rates[-1]])
    size = np.clip(1.0 + np.log10(amplitude / np.nanmax(amplitude)) / DECADES, 0.0, 1.0)
    frequency = np.outer(rates, orders)
    axes = figure.subplots()
    for q in RAYS:
        axes.plot(rates, q * rates, color=ORDER, linewidth=0.5)
        end = min(rates[-1], top / q)
        axes.annotate(f"{q:g}", (end, q * end), xytext=(1, 1), textcoords="offset points", fontsize=6.5)
    kept = (frequency <= top) & (size > 0.0)
    x = np.broadcast_to(rates[:, None], frequency.shape)
    axes.scatter(
        x[kept],
        frequency[kept],
        s=22.0 * size[kept] ** 2,
        color=MODELLED,
        linewidths=0,
        rasterized=True,
        label="torque lines, by their size",
    )
    for k, m in enumerate(data["named_modes"]):
        axes.axhline(m["frequency_hz"], color=MARK, linewidth=0.8, linestyle="--")
        # Modes close in frequency are labelled at opposite ends, so that their names do not overlap.
        place, side = ((0.995, "right"), (0.005, "left"))[k % 2]
        axes.annotate(
            m["name"],
            (place, m["frequency_hz"]),
            xycoords=("axes fraction", "data"),
            ha=side,
            va="bottom",
            fontsize=6.5,
            color=MARK,
        )
    inside = [c for c in data["crossings"] if rates[0] <= c["rate"] <= rates[-1]]
    axes.plot(
        [c["rate"] for c in inside],
        [c["frequency_hz"] for c in inside],
        "o",
        color=INK,
        fillstyle="none",
        markersize=5,
        label="crossings",
    )
    axes.set(xlabel=RATE, ylabel=FREQUENCY, xlim=(rates[0], rates[-1]), ylim=(0.0, top))
    legend_above(figure, axes, 2, **SMALL)


def _waterfall(mode: Data, figure: Any) -> None:
    """Draw the torque's lines over the frequency, stacked by rate."""
    rates, orders = number_array(mode["rates"]), number_array(mode["map"]["orders"])
    amplitude = number_array(mode["map"]["torque_amplitude_Nm"])
    chosen = np.unique(np.abs(rates - np.linspace(rates[0], rates[-1], SPECTRA)[:, None]).argmin(axis=1))
    height = 4.0 * (rates[-1] - rates[0]) / max(len(chosen) - 1, 1) / np.nanmax(amplitude[chosen])
    top = 1.1 * float(np.outer(rates, orders)[amplitude > SEEN * np.nanmax(amplitude)].max())
    axes = figure.subplots()
    # Drawn from the back, so that nearer spectra cover farther ones.
    for k in chosen[::-1]:
        f, known = rates[k] * orders, np.isfinite(amplitude[k])
        shown = known & (f <= top)
        axes.hlines(rates[k], 0.0, top, color=GRID, linewidth=0.2)
        axes.vlines(f[shown], rates[k], rates[k] + height * amplitude[k][shown], color=MODELLED, linewidth=1.1)
    scale = float(np.nanmax(amplitude[chosen]))
    axes.set(xlabel=FREQUENCY, ylabel=RATE, xlim=(0.0, top), title=f"tallest line {scale:.3g} N m")
    axes.title.set_fontsize(7.5)
    axes.grid(visible=False)


def _envelope(mode: Data, figure: Any) -> None:
    """Draw the largest torque line at any rate by third octaves, with its 95 % interval."""
    bands = mode["envelope"]["bands"]
    axes = figure.subplots()
    left, right = number_array([b["from_hz"] for b in bands]), number_array([b["to_hz"] for b in bands])
    size, ends = number_array([b["torque_amplitude_Nm"] for b in bands]), number_array([b["ci95_Nm"] for b in bands])
    axes.hlines(size, left, right, color=MODELLED, linewidth=1.6, label="largest line")
    for low, high, (least, most) in zip(left, right, ends, strict=True):
        axes.fill_between([low, high], least, most, color=MODELLED, alpha=0.3, linewidth=0)
    axes.fill_between([], [], color=MODELLED, alpha=0.3, label="95 % interval")
    axes.set(xscale="log", yscale="log", xlabel=FREQUENCY, ylabel=TORQUE)
    axes.set_ylim(bottom=max(np.nanmin(size), np.nanmax(size) * 10.0**-DECADES) / 2.0)
    for which in ("major", "minor"):
        getattr(axes.xaxis, f"set_{which}_formatter")(FuncFormatter(_tick_label))
    in_powers(axes.yaxis)
    legend_above(figure, axes, 2, **SMALL)


def _tick_label(value: float, _: int | None = None) -> str:
    """Return a frequency as text if its first digit is 1, 2 or 5.

    Examples
    --------
    >>> _tick_label(20.0), _tick_label(30.0)
    ('20', '')
    """
    return f"{value:g}" if f"{value:e}"[0] in "125" else ""


def _draw_coupling(data: Data, figure: Any) -> None:
    """Draw the criterion of one-way coupling over the frequency."""
    coupling = data["coupling"]
    axes = figure.subplots()
    axes.loglog(
        number_array(coupling["frequency_hz"]),
        number_array(coupling["loop_gain"]),
        color=MODELLED,
        label="|receptance x dynamic stiffness|",
    )
    axes.axhline(coupling["suffices_below"], color=LIMIT, linestyle="--", label="one-way suffices below")
    axes.axhline(1.0, color=INK, linewidth=0.6)
    axes.set(xlabel=FREQUENCY, ylabel="|R K|")
    for axis in (axes.xaxis, axes.yaxis):
        in_powers(axis)
    legend_above(figure, axes, 2, **SMALL)
