"""Figures of one mode of a budget: line of sight over the rate, at the worst rate, and over a profile."""

from __future__ import annotations

from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.ink.data import Data
from mechid.ink.figures import in_powers
from mechid.ink.palette import INK, LIMIT, series

LEVELS = 3
"""Position of the first requirement's colour in the series, after those of the lines of sight."""
RATE = "rate, full steps/s"
SMALLEST_SHARE = 1e-4
"""Share of the largest line below which lines are not drawn."""


def over_rate(data: Data, mode: Data, figure: Any) -> None:
    """Draw the RMS, and each requirement's level relative to its limit, over the rate with bands.

    The deciding coupling is solid, the one-way curve dashed. The band of a two-way RMS is the one-way band, scaled by
    the RMS.
    """
    rates, over = number_array(mode["rates"]), mode["over_rate"]
    rows = figure.subplots(2 if over["levels_rad"] else 1, 1, sharex=True, squeeze=False, gridspec_kw={"hspace": 0.22})
    top = rows[0, 0]
    one_way, band = number_array(over["rms_rad"]), number_array(over["rms_ci95_rad"])
    two_way = over["rms_two_way_rad"] is not None
    rms = number_array(over["rms_two_way_rad"]) if two_way else one_way
    scale = np.divide(rms, one_way, out=np.ones_like(rms), where=one_way > 0.0)
    for k, axis in enumerate(data["line_of_sight"]):
        ends = scale[:, k] * band[:, k].T
        top.fill_between(rates, *ends, color=series(k), alpha=0.35, linewidth=0)
        top.plot(rates, rms[:, k], color=series(k), label=f"{axis}, {'two-way' if two_way else 'one-way'}, 95 % band")
        if two_way:
            _draw_one_way(top, rates, one_way[:, k], series(k), f"{axis}, one-way")
    _other_states(mode, top)
    top.set(ylabel="line of sight RMS, rad", yscale="log", xlim=(rates[0], rates[-1]))
    in_powers(top.yaxis)
    _legend_above(top)
    if over["levels_rad"]:
        _levels(data, mode, rows[1, 0])
    rows[-1, 0].set_xlabel(RATE)


def _draw_one_way(axes: Any, rates: FloatArray, values: FloatArray, colour: str, label: str) -> None:
    """Draw a one-way curve that does not decide, thin and dashed."""
    axes.plot(rates, values, "--", color=colour, linewidth=0.6, alpha=0.8, label=label)


def _other_states(mode: Data, axes: Any) -> None:
    """Mark the other steady states at rates with several."""
    several = mode["steady_states"]["several"]
    others = [(here["rate"], rms) for here in several for s in here["states"] if not s["worst"] for rms in s["rms_rad"]]
    if others:
        axes.plot(*zip(*others, strict=True), "x", color=INK, markersize=3.0, label="other steady states, one-way")


def _levels(data: Data, mode: Data, axes: Any) -> None:
    rates = number_array(mode["rates"])
    limits = {r["requirement"]: r["limit_rad"] for r in data["requirements"]}
    over, decided = mode["over_rate"], mode["over_rate"]["decided"]
    for k, (name, levels) in enumerate(decided["levels_rad"].items()):
        band = number_array(decided["levels_ci95_rad"][name]) / limits[name]
        colour = series(k + LEVELS)
        axes.fill_between(rates, band[:, 0], band[:, 1], color=colour, alpha=0.35, linewidth=0)
        axes.plot(rates, number_array(levels) / limits[name], color=colour, label=f"{name}, {decided['coupling']}")
        if decided["coupling"] == "two-way":
            one_way = number_array(over["levels_rad"][name]) / limits[name]
            _draw_one_way(axes, rates, one_way, colour, "one-way, nominal unit" if k == 0 else "")
        for low, high in mode["avoid"].get(name, []):
            axes.axvspan(low, high, color=colour, alpha=0.15, linewidth=0)
    axes.axhline(1.0, color=LIMIT, linewidth=1.2, label="limit")
    axes.set(ylabel="level / limit", yscale="log")
    in_powers(axes.yaxis)
    _legend_above(axes)


def _legend_above(axes: Any) -> None:
    """Place the legend above the axes at the right, outside the curves."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=6, fontsize=6.5, borderaxespad=0.1, borderpad=0.1)


def line_of_sight(data: Data, mode: Data, figure: Any) -> None:
    """Draw the line of sight at the worst rate: over time, its lines and density, its cumulative RMS."""
    above, middle, below = figure.subplots(3, 1, gridspec_kw={"hspace": 0.52})
    samples, lines = mode["series"], mode["lines"]
    frequency, cumulative = number_array(lines["frequency_hz"]), mode["cumulative_rms_rad"]
    largest = max(max(column) for column in lines["line_of_sight_rad"])
    for k, axis in enumerate(data["line_of_sight"]):
        above.plot(samples["time_s"], samples["line_of_sight_rad"][k], color=series(k), label=f"{axis}, one-way")
        size = number_array(lines["line_of_sight_rad"][k])
        seen = size > SMALLEST_SHARE * largest
        middle.vlines(frequency[seen], SMALLEST_SHARE * largest, size[seen], color=series(k), linewidth=1.4 - 0.5 * k)
        middle.plot(
            frequency[seen], size[seen], "os^"[k % 3], color=series(k), markersize=2.5, label=f"{axis}, one-way"
        )
        if lines["line_of_sight_two_way_rad"] is not None:
            joined = number_array(lines["line_of_sight_two_way_rad"][k])
            middle.plot(
                frequency[seen],
                joined[seen],
                "x",
                color=series(k),
                markersize=3.5,
                label=f"{axis}, two-way",
            )
        total = [0.0, *cumulative["lines"][k]]
        below.step([0.0, *frequency], total, where="post", color=series(k), label=f"{axis}, lines, one-way")
    above.set(xlabel="time, s", ylabel="line of sight, rad")
    middle.set(xlabel="frequency, Hz", ylabel="amplitude, rad", yscale="log")
    middle.set_xlim(left=0.0)
    in_powers(middle.yaxis)
    below.set(xlabel="frequency, Hz", ylabel="cumulative RMS, rad", xlim=middle.get_xlim())
    if lines["random"] is not None:
        _density(lines["random"], middle)
    for axes in (above, middle, below):
        _legend_above(axes)


def _density(random: Data, axes: Any) -> None:
    """Draw the density of the non-repeating part on a separate axis: its unit differs from that of a line."""
    beside = axes.twinx()
    for k, column in enumerate(random["density_rad2_per_hz"]):
        root = np.sqrt(number_array(column))
        beside.plot(random["frequency_hz"], root, color=series(k), linewidth=0.4, alpha=0.7)
    beside.set(ylabel="not repeating, rad/√Hz", yscale="log")
    beside.grid(visible=False)
    in_powers(beside.yaxis)


def course(data: Data, mode: Data, figure: Any) -> None:
    """Draw a profile: extremes of the line of sight, windowed RMS with band, commanded rate."""
    above, below = figure.subplots(2, 1, sharex=True, gridspec_kw={"hspace": 0.22})
    course_, windowed = mode["course"], mode["windowed"]
    for k, axis in enumerate(data["line_of_sight"]):
        above.fill_between(
            course_["time_s"],
            course_["least_rad"][k],
            course_["largest_rad"][k],
            step="post",
            color=series(k),
            linewidth=0.3,
            alpha=0.8,
            label=f"{axis}, one-way",
        )
        band = number_array(windowed["rms_ci95_rad"][k])
        below.fill_between(windowed["time_s"], band[:, 0], band[:, 1], color=series(k), alpha=0.35, linewidth=0)
        below.plot(windowed["time_s"], windowed["rms_rad"][k], color=series(k), label=f"{axis}, one-way, 95 % band")
        if windowed["rms_two_way_rad"] is not None:
            below.plot(
                windowed["time_s"],
                windowed["rms_two_way_rad"][k],
                "--",
                color=series(k),
                linewidth=0.7,
                label=f"{axis}, two-way",
            )
    above.set(ylabel="line of sight, rad")
    below.set(xlabel="time, s", ylabel=f"RMS in {mode['rms_window_s']:g} s, rad", xlim=(0.0, mode["duration_s"]))
    figure.subplots_adjust(right=0.91)
    beside = below.twinx()
    beside.plot(windowed["time_s"], windowed["rate"], ":", color=INK, linewidth=0.8)
    beside.set(ylabel="rate, full steps/s (dotted)")
    beside.grid(visible=False)
    for axes in (above, below):
        _legend_above(axes)


def number_array(values: Any) -> FloatArray:
    """Return numbers as an array, NaN for None."""
    return np.array(values, dtype=np.float64)
