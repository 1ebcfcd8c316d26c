"""A design's figures: torque over rate, standard errors, step loss."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from mechid.ink.figures import STYLE, WIDTH_IN, made
from mechid.ink.palette import INK, series

STEPPINGS = {"full": (series(0), "-"), "half": (series(1), "--"), "micro": (series(2), "-")}
"""Colour and style of each stepping."""
RATE, AMPLITUDE = "step rate, full steps/s", "torque amplitude, N m"


def design_figures(data: Mapping[str, Any]) -> dict[str, Figure]:
    """Return the figures of a design by name, from what `design_data` made."""
    rows = len(data["parameters"])
    with mpl.rc_context(STYLE), np.errstate(all="ignore"):
        return {
            "torque_over_rate": made(partial(_torque_over_rate, data), 4.4),
            "standard_errors": made(partial(_standard_errors, data), 0.22 * rows + 0.9),
            "step_loss": made(partial(_step_loss, data), 2.8),
        }


def _torque_over_rate(data: Mapping[str, Any], figure: Any) -> None:
    """Draw a panel for each stepping: the curve of the values believed in the band of all that may be true."""
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
    """Return what the band holds."""
    return f"least to largest of {mechanisms} mechanisms that may be true"


def _standard_errors(data: Mapping[str, Any], figure: Any) -> None:
    """Draw each parameter's standard error relative to that of the planned records, with its 90 % over the prior."""
    figure.subplots_adjust(left=1.9 / WIDTH_IN)
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
    """Draw the limits beyond which steps are lost; a bar is a hole below, where they are lost too."""
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
