"""Plots of a budget: level of each requirement relative to its limit, and line of sight of a mode."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mechid.budgets.mode_budget import ModeBudget
from mechid.ink.axes import axes_or_new
from mechid.ink.palette import LIMIT, SERIES, series
from mechid.ink.quantities import TIME

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FULL_STEPS = "rate, full steps/s"


def plot_requirements(rows: Sequence[Mapping[str, Any]], ax: Axes | None) -> Axes:
    """Draw each requirement's deciding level relative to its limit, with its 95 % interval."""
    axes, decided = axes_or_new(ax), [row["decided"] for row in rows]
    share = 1.0 - np.array([[*reversed(one["margin95"]), one["margin"]] for one in decided])
    places = np.arange(len(rows))
    axes.hlines(places, share[:, 0], share[:, 1], color=series(0), linewidth=2.0, label="95 % interval")
    axes.plot(share[:, 2], places, "o", color=series(0), label="level")
    axes.axvline(1.0, color=LIMIT, linewidth=1.2, label="limit")
    axes.set_yticks(places, [f"{row['requirement']}\n{row['mode']}" for row in rows])
    axes.invert_yaxis()
    axes.set_xlabel("level over limit")
    axes.legend(loc="best")
    return axes


def plot_mode(made: ModeBudget, ax: Axes | None) -> Axes:
    """Draw the RMS of the line of sight over the rate, or over time for a profile."""
    axes = axes_or_new(ax)
    if made.course is not None:
        times, levels, over = made.course.window_times_s, made.course.windowed_rms(), TIME
        names = made.course.axes
    else:
        times, levels, over = made.mode.rates, np.array([r.rms() for r in made.responses]), FULL_STEPS
        names = made.responses[0].axes
    axes.set_prop_cycle(color=SERIES)
    for name, level in zip(names, levels.T, strict=True):
        axes.plot(times, level, marker="." if len(times) < 40 else "", linewidth=0.8, label=name)
    if made.course is None and made.two_way:
        axes.set_prop_cycle(color=SERIES)
        for name, level in zip(names, np.array([r.rms() for r in made.two_way]).T, strict=True):
            axes.plot(times, level, "--", linewidth=0.8, label=f"{name}, two-way")
    axes.set_xlabel(over)
    axes.set_ylabel("line of sight, RMS, rad")
    axes.set_title(made.mode.name, loc="left")
    axes.legend(loc="best")
    return axes
