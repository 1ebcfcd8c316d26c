"""Figures of a bootstrap: scatter of the refits of each parameter, and correlated pairs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from itertools import combinations
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from mechid.arrays import FloatArray
from mechid.identification.refit.bootstrap import DrawOutcome
from mechid.ink.figures import STYLE, make_figure
from mechid.ink.palette import INK, MEASURED, MODELLED

SCATTER_NAME, PAIRS_NAME = "bootstrap_scatter", "bootstrap_pairs"
ROW_IN, MARGIN_IN, PAIRS_IN = 0.2, 0.8, 2.3
# With fewer draws, pairs are correlated by chance.
MOST_PAIRS, LEAST_CORRELATION, LEAST_DRAWS = 3, 0.5, 8
"""Most drawn pairs, their least correlation, and the least number of draws."""
NAMES_FROM = 0.3
"""Left margin as a share of the width, for names."""


def bootstrap_figures(data: Mapping[str, Any]) -> Iterator[tuple[str, Figure]]:
    """Yield the figures for the result of `bootstrap_numbers`."""
    with mpl.rc_context(STYLE), np.errstate(all="ignore"):
        yield SCATTER_NAME, make_figure(partial(_scatter, data), MARGIN_IN + ROW_IN * len(data["parameters"]))
        pairs = closest_pairs(data)
        if pairs:
            yield PAIRS_NAME, make_figure(partial(_pairs, data, pairs), PAIRS_IN)


def draws_in_sigmas(data: Mapping[str, Any]) -> dict[str, FloatArray]:
    """Return deviations of the refits in standard errors, or in their scatter if a parameter has no standard error.

    Failed refits are omitted; angles differ by at most half a turn.
    """
    refits = [refit for refit in data["refits"] if refit["outcome"] != DrawOutcome.FAILED.code]
    found = {}
    for name, one in data["parameters"].items():
        sigma = one["std_error"] or one["deviation"]
        off = np.array([refit[name] for refit in refits], dtype=np.float64) - one["value"]
        if one["unit"] == "deg":
            off = (off + 180.0) % 360.0 - 180.0
        if sigma and off.size:
            found[name] = off / sigma
    return found


def closest_pairs(data: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the pairs of parameters with the most correlated refits, in descending order."""
    if len(data["refits"]) < LEAST_DRAWS:
        return []
    # A constant has no correlation.
    draws = {name: own for name, own in draws_in_sigmas(data).items() if np.ptp(own) > 0.0 and np.all(np.isfinite(own))}
    sizes = {pair: abs(float(np.corrcoef(draws[pair[0]], draws[pair[1]])[0, 1])) for pair in combinations(draws, 2)}
    ordered = sorted(sizes, key=lambda pair: -sizes[pair])
    return [pair for pair in ordered[:MOST_PAIRS] if sizes[pair] > LEAST_CORRELATION]


def _scatter(data: Mapping[str, Any], figure: Any) -> None:
    axes, draws = figure.subplots(), draws_in_sigmas(data)
    # 95 % of a normal distribution, as much as each bar holds of the refits.
    axes.axvspan(-1.96, 1.96, color=MODELLED, alpha=0.15, linewidth=0.0)
    for row, own in enumerate(draws.values()):
        low, mean, high = np.quantile(own, 0.025), own.mean(), np.quantile(own, 0.975)
        axes.plot((low, high), (row, row), color=MEASURED, linewidth=3.0)
        axes.plot(mean, row, "o", color=INK, markersize=3.0)
    axes.set_yticks(range(len(draws)), list(draws))
    # Downwards, so that the parameters have the order of the table.
    axes.set_ylim(len(draws) - 0.5, -0.5)
    axes.set_xlabel("from the estimate, standard errors")
    figure.subplots_adjust(left=NAMES_FROM)


def _pairs(data: Mapping[str, Any], pairs: list[tuple[str, str]], figure: Any) -> None:
    draws = draws_in_sigmas(data)
    for axes, (one, other) in zip(np.atleast_1d(figure.subplots(1, len(pairs))), pairs, strict=True):
        axes.plot(draws[one], draws[other], ".", color=MEASURED, markersize=3.0)
        axes.plot(0.0, 0.0, "+", color=INK)
        axes.set_xlabel(one, fontsize=6.5)
        axes.set_ylabel(other, fontsize=6.5)
    figure.subplots_adjust(wspace=0.45)
