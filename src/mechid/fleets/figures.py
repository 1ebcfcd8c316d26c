"""Figures of a fleet: parameters over its campaigns, trends over covariates, changes of its units."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from mechid.ink.data import Data
from mechid.ink.figures import STYLE, make_figure
from mechid.ink.palette import ESTIMATE, INK, series

COLUMNS, ROW_IN, NAMES_IN = 3, 1.45, 0.85
OFF, MEAN = series(1), series(5)
"""Colours of outliers, and of a fleet's mean with its spread."""
REACH = 1.96
"""Half-length of the error bars in standard errors: 95 %."""
MOST_NAMES = 30
"""Campaigns that are named below a panel; more are counted."""
LETTERS = 16
"""Largest number of letters of a name below a panel."""
SHOWN = 12
"""Panels of trends and of changes at most, the clearest first."""


def fleet_figures(data: Data) -> Iterator[tuple[str, Figure]]:
    """Yield the figures with their names.

    Parameters
    ----------
    data : mapping
        Result of `fleet_texts`.
    """
    for name, panels, names in _drawings(data):
        # Rounded up.
        rows = -(-len(panels) // COLUMNS)
        with mpl.rc_context(STYLE):
            yield (
                f"fleet_{name}",
                make_figure(partial(_panels, panels, names), rows * ROW_IN + (NAMES_IN if names else 0.4) + 0.2),
            )


def figure_names(data: Data) -> list[str]:
    """Return the names of the figures that `fleet_figures` yields of the same data."""
    return [f"fleet_{name}" for name, *_ in _drawings(data)]


def _drawings(data: Data) -> Iterator[tuple[str, list[Any], Sequence[str]]]:
    """Yield the name of each figure, its panels, and the names below its lowest panels."""
    labels = [c["label"] for c in data["campaigns"]]
    drawn = [p for p in data["parameters"] if any(v and v["level"] is not None for v in p["values"])]
    if drawn:
        yield "parameters", [partial(_parameter, data, p) for p in drawn], labels
    trends = [t for t in data["trends"] if t["found"]][:SHOWN]
    if trends:
        yield "trends", [partial(_trend, t) for t in trends], ()
    found = dict.fromkeys(
        (c["name"], tuple(c["states"])) for c in (*data["mean_changes"], *data["changes"]) if c["found"]
    )
    if found:
        units = list(dict.fromkeys(c["unit"] for c in data["changes"]))
        yield "changes", [partial(_change, data, name, states, units) for name, states in list(found)[:SHOWN]], units


def _panels(panels: Sequence[Any], names: Sequence[str], figure: Any) -> None:
    """Draw small panels in rows of three, with names below the lowest of each column."""
    rows, height = -(-len(panels) // COLUMNS), figure.get_figheight()
    below = NAMES_IN if names else 0.42
    figure.subplots_adjust(
        left=0.075,
        right=0.99,
        bottom=below / height,
        top=1.0 - 0.24 / height,
        wspace=0.3,
        # Without common names below, each panel has an axis label of its own.
        hspace=0.32 if names else 0.62,
    )
    grid = figure.subplots(rows, COLUMNS, squeeze=False)
    for k, axes in enumerate(grid.flat):
        if k >= len(panels):
            axes.set_axis_off()
            continue
        axes.tick_params(labelsize=6.0)
        panels[k](axes)
        if names:
            _set_names(axes, names, shown=k + COLUMNS >= len(panels))


def _set_names(axes: Any, names: Sequence[str], *, shown: bool) -> None:
    named = shown and len(names) <= MOST_NAMES
    axes.set_xlim(-0.6, len(names) - 0.4)
    axes.set_xticks(
        range(len(names)), [*map(shorten, names)] if named else [""] * len(names), rotation=90, fontsize=5.0
    )
    axes.grid(axis="x", visible=False)


def shorten(name: str) -> str:
    """Return a name with its middle replaced if it is too long.

    Examples
    --------
    >>> shorten("FM1 before vibration, third run")
    'FM1 befo…hird run'
    """
    half = LETTERS // 2
    return f"{name[:half]}…{name[-half:]}" if len(name) > LETTERS else name


def _title(axes: Any, name: str, unit: str) -> None:
    axes.set_title(f"{name}, {unit}" if unit else name, fontsize=6.5, loc="left", pad=3.0)


def _parameter(data: Data, p: Data, axes: Any) -> None:
    """Draw the values of the campaigns with 95 % error bars, the mean, and the spread as a band."""
    _title(axes, p["name"], p["text"]["unit"] + (", trend taken out" if p["along"] else ""))
    if p["mean"] is not None:
        axes.axhspan(p["mean"] - p["spread"], p["mean"] + p["spread"], color=MEAN, alpha=0.18, linewidth=0)
        axes.axhline(p["mean"], color=MEAN, linewidth=0.9)
    off = {one["unit"] for one in p["outliers"]}
    for k, (v, c) in enumerate(zip(p["values"], data["campaigns"], strict=True)):
        if v is not None and v["level"] is not None:
            colour = OFF if c["unit"] in off else ESTIMATE
            axes.errorbar(
                k, v["level"], yerr=REACH * v["std_error"], fmt="o", color=colour, markersize=2.6, elinewidth=0.8
            )


def _trend(t: Data, axes: Any) -> None:
    """Draw a parameter over a covariate with its line."""
    points = t["points"]
    x, y, error = (np.array(points[key], dtype=np.float64) for key in ("covariate", "value", "error"))
    axes.errorbar(x, y, yerr=REACH * error, fmt="o", color=ESTIMATE, markersize=2.6, elinewidth=0.8)
    ends = np.array([x.min(), x.max()])
    axes.plot(ends, t["level"] + t["slope"] * (ends - t["reference"]), color=series(0), linewidth=1.1)
    _title(axes, t["name"], "")
    axes.set_xlabel(t["text"]["covariate"], fontsize=6.0, labelpad=1.0)


def _change(data: Data, name: str, states: Sequence[str], units: Sequence[str], axes: Any) -> None:
    """Draw the change of each unit with its 95 % error bar, findings in colour, and the mean change."""
    _title(axes, name, "")
    mean = next((c for c in data["mean_changes"] if c["name"] == name and c["states"] == list(states)), None)
    if mean is not None:
        axes.axhspan(*mean["mean95"], color=MEAN, alpha=0.18, linewidth=0)
        axes.axhline(mean["mean"], color=MEAN, linewidth=0.9)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    for c in data["changes"]:
        if c["name"] == name and c["states"] == list(states):
            colour = OFF if c["found"] else ESTIMATE
            axes.errorbar(
                units.index(c["unit"]),
                c["difference"],
                yerr=REACH * c["error"],
                fmt="o",
                color=colour,
                markersize=2.6,
                elinewidth=0.8,
            )
