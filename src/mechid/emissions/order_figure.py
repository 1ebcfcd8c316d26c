"""Figure of the largest orders of a predicted emission over the rate, with what was measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mechid.budgets.prediction_figures import RATE
from mechid.ink.figures import in_powers, legend_above
from mechid.ink.palette import series


def draw_orders(orders: Sequence[Mapping[str, Any]], figure: Any) -> None:
    """Draw the largest orders over the rate: predicted lines, their bounds dotted, and measured lines as points."""
    axes = figure.subplots()
    for k, one in enumerate(orders):
        amplitude, bound = (
            np.array([np.nan if value is None else value for value in one[key]], dtype=np.float64)
            for key in ("amplitude", "bound95")
        )
        # A single rate makes no line.
        marker = "." if len(amplitude) == 1 else ""
        axes.plot(
            one["rates"], amplitude, color=series(k), linewidth=1.0, marker=marker, label=f"order {one['order']:g}"
        )
        axes.plot(one["rates"], bound, color=series(k), linewidth=0.7, linestyle=":")
        if one["measured"]:
            rate, size, sigma = np.array([[p["rate"], p["amplitude"], p["sigma"]] for p in one["measured"]]).T
            axes.errorbar(np.abs(rate), size, 1.96 * sigma, color=series(k), fmt="o", markersize=3.0, linewidth=0.8)
    axes.set(xlabel=RATE, ylabel="torque: amplitude (peak), N m", yscale="log")
    in_powers(axes.yaxis)
    legend_above(figure, axes, 4)
