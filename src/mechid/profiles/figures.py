"""Figures of profiles: likelihood curve and parabola of the standard error."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from mechid.ink.figures import STYLE, legend_above, make_figure
from mechid.ink.palette import LIMIT, MEASURED, MODELLED

HEIGHT_IN = 2.6
COLUMNS = 3
PARABOLA_POINTS = 200
ABOVE_LEVEL = 2.0
"""Height of the figure, in multiples of the confidence level."""


def figure_name(parameter: str) -> str:
    """Return the name of a parameter's figure."""
    return f"profile_{parameter}"


def profile_figures(data: Mapping[str, Any]) -> Iterator[tuple[str, Figure]]:
    """Yield a figure for each profile of `profile_numbers`."""
    for name, one in data["profiles"].items():
        with mpl.rc_context(STYLE), np.errstate(all="ignore"):
            yield figure_name(name), make_figure(partial(_curve, name, one), HEIGHT_IN)


def _curve(name: str, one: Mapping[str, Any], figure: Any) -> None:
    axes = figure.subplots()
    level = one["level_coloured"] or one["level"]
    limits = one["ci95_coloured"] if one["level_coloured"] else one["ci95"]
    points = [(p["value"], p["rise"]) for p in one["points"] if np.isfinite(p["rise"])]
    x, rise = np.array(points).T
    axes.plot(x, rise, "o-", color=MEASURED, markersize=3.0, linewidth=1.1, label="profile likelihood")
    # The rise of the cost counts noise as white, so its parabola is that of the white standard error.
    error = one["std_error_white"]
    if error:
        at = np.linspace(x[0], x[-1], PARABOLA_POINTS)
        axes.plot(at, ((at - one["value"]) / error) ** 2, "--", color=MODELLED, label="by the standard error")
    axes.axhline(level, color=LIMIT, linewidth=0.8, linestyle=":", label="95 %")
    for limit in (value for value in limits if value is not None):
        axes.axvline(limit, color=LIMIT, linewidth=0.8, linestyle=":")
    unit = "" if one["unit"] == "1" else f", {one['unit']}"
    axes.set(xlabel=f"{name}{unit}", ylabel="rise of the cost, σ²")
    # A refit may find a lower cost than the estimate.
    axes.set_ylim(min(0.0, float(rise.min())), ABOVE_LEVEL * level)
    legend_above(figure, axes, COLUMNS)
