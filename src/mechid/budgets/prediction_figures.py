"""Figure of a predicted requirement: the value that decides at each rate over its limit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mechid.ink.figures import in_powers, legend_above
from mechid.ink.palette import LIMIT, MEASURED, series

RATE = "step rate, full steps/s"


def predicts(predicted: Mapping[str, Any] | None) -> bool:
    """Return whether a requirement has predicted values at more than one rate."""
    return predicted is not None and len({at["rate"] for at in predicted["at_rates"] if at["worst"]}) > 1


def draw_shares_of_limit(
    direction: str, predicted: Mapping[str, Any], measured: Sequence[Mapping[str, Any]], figure: Any
) -> None:
    """Draw the value that decides at each rate over its limit: predicted with its bound, and measured."""
    axes = figure.subplots()
    at_rates = [at for at in predicted["at_rates"] if at["worst"]]
    for k, stepping in enumerate(dict.fromkeys(at["stepping"] for at in at_rates)):
        own = [at for at in at_rates if at["stepping"] == stepping]
        rates = [at["rate"] for at in own]
        value, upper = (_over_limit(own, key) for key in ("value", "upper"))
        # A single rate makes no line.
        marker = "." if len(own) == 1 else ""
        axes.plot(rates, value, color=series(k), linewidth=1.0, marker=marker, label=f"predicted, {stepping}")
        axes.plot(rates, upper, color=series(k), linewidth=0.7, linestyle=":")
    points = [at for at in measured if at["worst"] and at["rate"] is not None]
    if points:
        value, lower, upper = (_over_limit(points, key) for key in ("value", "lower", "upper"))
        axes.errorbar(
            [abs(at["rate"]) for at in points],
            value,
            [np.maximum(value - lower, 0.0), np.maximum(upper - value, 0.0)],
            color=MEASURED,
            fmt="o",
            markersize=3.0,
            capsize=2.0,
            linewidth=0.8,
            label="measured",
        )
    axes.axhline(1.0, color=LIMIT, linestyle="--", label="limit")
    axes.set(xlabel=RATE, ylabel=f"{direction}: worst value over its limit", yscale="log")
    in_powers(axes.yaxis)
    # One row: the space above the axes holds no second one.
    legend_above(figure, axes, 6)


def _over_limit(rows: Sequence[Mapping[str, Any]], key: str) -> Any:
    return np.array([at["worst"][key] / at["worst"]["limit"] for at in rows])
