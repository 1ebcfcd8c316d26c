"""Figures of a quiet drive: the table over the electrical angle, and the levels over the rate."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from mechid.ink.figures import STYLE, legend_above, make_figure
from mechid.ink.palette import LIMIT, series

HEIGHT_IN = 2.8
TURN_DEG = 360.0
LEVELS = {"N*m": "RMS torque, N m", "rad": "RMS line of sight, rad"}
"""Label by the unit of the level."""


def quiet_figures(data: Mapping[str, Any]) -> Iterator[tuple[str, Figure]]:
    """Yield the figures of the result of `quiet_numbers`."""
    for name, draw in (("quiet_table", _table), ("quiet_rates", _rates)):
        with mpl.rc_context(STYLE):
            yield name, make_figure(partial(draw, data), HEIGHT_IN)


def _table(data: Mapping[str, Any], figure: Any) -> None:
    """Draw the table's change, which its values would hide."""
    axes = figure.subplots()
    change = np.array(data["table"]["values"]) - np.array(data["table"]["nominal"])
    angle = TURN_DEG * np.arange(len(change) + 1) / len(change)
    for phase, name in enumerate(("phase A", "phase B")):
        axes.step(angle, np.append(change[:, phase], change[0, phase]), where="post", color=series(phase), label=name)
    axes.set(xlabel="electrical angle, deg", ylabel="change of the table, of the peak", xlim=(0.0, TURN_DEG))
    legend_above(figure, axes, 2)


def _rates(data: Mapping[str, Any], figure: Any) -> None:
    """Draw level and bound of each stepping, and the limit."""
    axes = figure.subplots()
    curves = data["survey"]["curves"]
    for k, curve in enumerate(curves):
        rates = np.array(curve["rates"])
        level, bound = (np.array(curve[key], dtype=np.float64) for key in ("level", "bound"))
        axes.plot(rates, level, color=series(k), label=curve["stepping"])
        axes.fill_between(rates, level, bound, color=series(k), alpha=0.25, linewidth=0.0)
    axes.axhline(data["survey"]["limit"], color=LIMIT, linewidth=0.8, linestyle=":", label="limit")
    axes.set(xlabel="step rate, full steps/s", ylabel=LEVELS[data["level_unit"]], yscale="log")
    legend_above(figure, axes, len(curves) + 1)
