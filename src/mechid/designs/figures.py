"""Figures of a design: errors before and after each record, rates of the records, step loss, torque over rate."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from mechid.arrays import FloatArray
from mechid.ink.digits import plain
from mechid.ink.figures import BAR_IN, STYLE, WIDTH_IN, in_powers, legend_above, made
from mechid.ink.palette import INK, ON_DARK, ON_LIGHT, series

ERRORS, ERRORS_BY_RECORD, RATES = "standard_errors", "errors_by_record", "record_rates"
LOSS, TORQUE = "step_loss", "torque_over_rate"
"""Names of the figures."""
NAMES_IN = 1.9
"""Width of the parameters' names at the left, in."""
BELOW_IN = 0.95
"""Height of the records' names below, in."""
NAMED_COLUMNS, NAMED_RECORDS, NUMBERED_RECORDS = 40, 12, 6
"""Records up to which each has its name below the errors, its name over its rate, its errors written out."""
DARK = 1.5
"""Sum of red, green and blue below which text in a cell is light."""
LARGEST_ERROR = 1.0
"""Relative error beyond which a parameter is undetermined."""

STEPPINGS = {"full": (series(0), "-"), "half": (series(1), "--"), "micro": (series(2), "-")}
"""Colour and style of each stepping."""
RATE, AMPLITUDE = "step rate, full steps/s", "torque amplitude, N m"


def design_figures(data: Mapping[str, Any]) -> Iterator[tuple[str, Figure]]:
    """Yield the figures of the data of `design_numbers`, with their names."""
    height = 0.22 * len(data["parameters"]) + 0.9
    drawings: dict[str, tuple[float, Callable[..., None]]] = {
        ERRORS: (height, _standard_errors),
        ERRORS_BY_RECORD: (height + 0.6, _errors_by_record),
        RATES: (2.4, _record_rates),
        LOSS: (2.8, _step_loss),
        TORQUE: (4.4, _torque_over_rate),
    }
    for name, (height_in, draw) in drawings.items():
        with mpl.rc_context(STYLE), np.errstate(all="ignore"):
            yield name, made(partial(draw, data), height_in)


def _torque_over_rate(data: Mapping[str, Any], figure: Any) -> None:
    """Draw a panel for each stepping: the curve at the assumed values in the band of all possible mechanisms."""
    axes = figure.subplots(3, 1, sharex=True, gridspec_kw={"hspace": 0.12})
    for ax, m in zip(axes, data["torque_over_rate"], strict=True):
        colour, style = STEPPINGS[m["stepping"]]
        rate, amplitude = np.array(m["rate"]), np.array(m["amplitude_Nm"], dtype=np.float64)
        low, high = (np.array(m[key], dtype=np.float64) for key in ("low_Nm", "high_Nm"))
        ax.fill_between(rate, low, high, color=colour, alpha=0.15, linewidth=0.0, label=_band_words(m["mechanisms"]))
        ax.plot(rate, amplitude, color=colour, linestyle=style, linewidth=1.2, label="at the values believed")
        for p in m["peaks"][:4]:
            ax.annotate(
                f"{p['rate']:.0f}",
                (p["rate"], p["amplitude_Nm"]),
                xytext=(0, 2),
                ha="center",
                textcoords="offset points",
                fontsize=7.0,
                color=colour,
            )
        ax.set(ylim=(0.0, 1.05 * float(np.nanmax(high))), xlim=(0.0, rate[-1]))
        ax.legend(title=f"{m['stepping']} stepping", loc="upper right", fontsize=7.0, borderpad=0.2)
    axes[1].set_ylabel(AMPLITUDE)
    axes[-1].set_xlabel(RATE)


def _band_words(mechanisms: int) -> str:
    """Return the label of the band."""
    return f"least to largest of {mechanisms} mechanisms that may be true"


def _standard_errors(data: Mapping[str, Any], figure: Any) -> None:
    """Draw each parameter's standard error, planned and chosen, from its median to its 90 % quantile over the prior."""
    figure.subplots_adjust(left=NAMES_IN / WIDTH_IN)
    axes = figure.subplots()
    rows = data["parameters"]
    at = np.arange(len(rows))
    for key, colour, marker, shift in (("planned", series(0), "o", -0.12), ("chosen", series(1), "s", 0.12)):
        middle, high = (np.array([_over_value(p, p[f"{key}_spread"][k]) for p in rows]) for k in (0, 1))
        axes.hlines(at + shift, middle, high, color=colour, linewidth=1.2, alpha=0.6)
        axes.plot(middle, at + shift, marker, color=colour, markersize=4, linestyle="", label=_label(data, key))
    axes.set_xscale("log")
    axes.set_yticks(at, [p["name"] for p in rows])
    axes.invert_yaxis()
    axes.set_xlabel("standard error over value (phases: rad); median and 90 % of mechanisms")
    axes.legend(ncols=2, loc="lower right", bbox_to_anchor=(1.0, 0.99), borderpad=0.1)


def relative_errors(data: Mapping[str, Any]) -> FloatArray:
    """Return each parameter's standard error over its value, (parameters, 1 + records), NaN if unknown."""
    return np.array([[_over_value(p, sigma) for sigma in p["by_record"]] for p in data["parameters"]])


def _errors_by_record(data: Mapping[str, Any], figure: Any) -> None:
    """Draw one row per parameter, with one column before the first record and one after each."""
    records, errors = data["chosen"]["records"], relative_errors(data)
    # Undetermined parameters have no colour: they would stretch the scale over all the others.
    known = np.where(errors < LARGEST_ERROR, errors, np.nan)
    norm = LogNorm(*_decades_of(known if data["after_fit"] else known[:, 1:]), clip=True)
    bottom = BELOW_IN / figure.get_figheight()
    figure.subplots_adjust(left=NAMES_IN / WIDTH_IN, right=1.0 - BAR_IN / WIDTH_IN, bottom=bottom)
    axes = figure.subplots()
    image = axes.pcolormesh(known, norm=norm, cmap="cividis_r", rasterized=True)
    axes.set_yticks(np.arange(len(errors)) + 0.5, [p["name"] for p in data["parameters"]])
    names = ["now" if data["after_fit"] else "no record", *(r["name"] for r in records)]
    shown = names if len(names) <= NAMED_COLUMNS else [""] * len(names)
    axes.set_xticks(np.arange(len(names)) + 0.5, shown, rotation=40, ha="right", rotation_mode="anchor")
    axes.invert_yaxis()
    axes.grid(visible=False)
    if len(records) <= NUMBERED_RECORDS:
        _write_errors(axes, image, errors)
    in_powers(figure.colorbar(image, ax=axes, label="standard error over value", pad=0.02, fraction=0.05).ax.yaxis)


def _decades_of(errors: FloatArray) -> tuple[float, float]:
    """Return the powers of ten that enclose errors."""
    if not np.isfinite(errors).any():
        return 0.1 * LARGEST_ERROR, LARGEST_ERROR
    low, high = np.log10([np.nanmin(errors), np.nanmax(errors)])
    return float(10.0 ** np.floor(low)), float(10.0 ** np.ceil(high))


def _write_errors(axes: Any, image: Any, errors: FloatArray) -> None:
    """Write each error into its cell, light on dark."""
    for (row, column), value in np.ndenumerate(errors):
        is_known = value < LARGEST_ERROR
        is_dark = is_known and sum(image.cmap(image.norm(value))[:3]) < DARK
        place, text = (column + 0.5, row + 0.5), plain(value, 2) if is_known else "·"
        colour = INK if not is_known else ON_DARK if is_dark else ON_LIGHT
        axes.text(*place, text, ha="center", va="center", fontsize=6.5, color=colour)


def _record_rates(data: Mapping[str, Any], figure: Any) -> None:
    """Draw the rates of the chosen records in sequence, with names where there is room."""
    axes, start_s, records = figure.subplots(), 0.0, data["chosen"]["records"]
    for r in records:
        colour, style = STEPPINGS[r["stepping"]]
        times, rates = np.array(r["rate_profile"]).T
        at = np.unique(np.clip([0.0, *times, r["duration_s"]], 0.0, r["duration_s"]))
        rate = [0.0, *np.interp(at, times, rates), 0.0]
        label = None if r["stepping"] in axes.get_legend_handles_labels()[1] else r["stepping"]
        time = start_s + np.array([0.0, *at, r["duration_s"]])
        axes.plot(time, rate, style, color=colour, linewidth=1.2, label=label)
        if len(records) <= NAMED_RECORDS:
            place = (start_s + 0.5 * r["duration_s"], max(rate, key=abs))
            axes.annotate(r["name"], place, (0, 2), textcoords="offset points", ha="center", fontsize=6.5)
        start_s += r["duration_s"] + data["limits"]["between_s"]
    axes.margins(y=0.15)
    axes.set(xlabel="test time, s", ylabel=RATE, xlim=(0.0, max(start_s, 1e-9)))
    legend_above(figure, axes, len(STEPPINGS))


def _label(data: Mapping[str, Any], key: str) -> str:
    if key == "chosen":
        return "with the chosen records"
    return "now" if data["after_fit"] else "planned records"


def _over_value(p: Mapping[str, Any], sigma: float | None) -> float:
    if sigma is None:
        return float("nan")
    if p["unit"] == "deg":
        return float(np.radians(sigma))
    return sigma / abs(p["size"]) if p["size"] else float("nan")


def _step_loss(data: Mapping[str, Any], figure: Any) -> None:
    """Draw the limits beyond which steps are lost; a bar marks a hole below a limit."""
    axes = figure.subplots(1, 3, sharey=True, gridspec_kw={"wspace": 0.08})
    supply = "current" if any(r["changed"] == "current" for r in data["step_loss"]) else "voltage"
    kinds = (
        ("load inertia", "factor on the load's inertia", 1.0),
        (supply, f"factor on the {supply}", 1.0),
        ("friction torque", "friction torque added, N m", 0.0),
    )
    for ax, (changed, label, unchanged) in zip(axes, kinds, strict=True):
        for stepping, (colour, style) in STEPPINGS.items():
            rows = [r for r in data["step_loss"] if r["stepping"] == stepping and r["changed"] in ("", changed)]
            points = sorted(((r["to"] if r["changed"] else unchanged, r) for r in rows), key=lambda p: p[0])
            x = [p[0] for p in points]
            for key, marker in (("pull_in", "o"), ("pull_out", "^")):
                y = [float("nan") if p[1][key]["limit"] is None else p[1][key]["limit"] for p in points]
                name = f"{stepping}, {key.replace('_', '-')}"
                ax.plot(x, y, linestyle=style, marker=marker, markersize=3, color=colour, label=name)
                for to, row in points:
                    for low, high in row[key]["holes"]:
                        ax.vlines(to, low, high, color=colour, linewidth=4.0, alpha=0.35)
        ax.axvline(unchanged, color=INK, linewidth=0.8, linestyle=":")
        ax.set_xlabel(label)
    axes[0].set_xscale("log", base=2)
    axes[0].xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axes[0].set_ylabel(RATE)
    axes[0].set_ylim(bottom=0.0)
    axes[0].legend(fontsize=6.0, loc="lower left")
