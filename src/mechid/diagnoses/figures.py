"""Figures of a diagnosis: residual spectra with the share of each effect, and the worst stretch over time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from mechid.identification.diagnosis.figure_data import FigureData, ResidualSpectra, Stretch
from mechid.ink.extremes import reduce_to_extremes
from mechid.ink.figures import LEFT_IN, RIGHT_IN, STYLE, WIDTH_IN, Drawing, in_powers, make_figure, over_time
from mechid.ink.palette import EFFECT, INK, MEASURED, MODELLED, NOISE, series
from mechid.ink.palette import RESIDUAL as RESIDUAL_COLOUR
from mechid.ink.quantities import DENSITY, FREQUENCY, RESIDUAL, TIME, TORQUE, axis_labels
from mechid.simulation.simulator import TimeBase

SHARES = tuple(map(series, range(1, 7)))
"""Colours of the effects, in order of their share."""
BELOW_NOISE = 10.0
"""Factor by which the axis extends below the density of the noise."""
# The logarithm of 0 cannot be drawn.
FAINTEST = 1e-3
"""Factor below the end of the axis at which values are clipped."""
LEGEND_COLUMNS, LEGEND_ROW_IN, TOP_IN = 3, 0.17, 0.1
LABEL_ROWS, LABEL_IN = 3, 0.3
STRETCH_NAME = "diagnosis_stretch"
AS_WRITTEN, WITH_EFFECTS, NEAREST = "mechanism as written", "with the effects", "with what comes nearest"
"""Labels of the models; the last is the nearest candidate, if no effect explains enough to be named."""


def spectrum_name(record: str) -> str:
    """Return the name of a record's spectrum figure."""
    return f"diagnosis_{record}_spectrum"


def hertz(frequency: float) -> str:
    """Format a frequency with three digits.

    Examples
    --------
    >>> hertz(56.75), hertz(1000.0)
    ('56.8', '1000')
    """
    return f"{float(f'{frequency:.3g}'):g}"


def diagnosis_figures(pictures: FigureData) -> Iterator[tuple[str, Figure]]:
    """Yield named figures."""
    for name, height, draw in _drawings(pictures):
        with mpl.rc_context(STYLE), np.errstate(all="ignore"):
            yield name, make_figure(draw, height)


def _drawings(pictures: FigureData) -> Iterator[tuple[str, float, Drawing]]:
    for one in pictures.spectra:
        acts = {name: own[one.record].frequencies_hz for name, own in pictures.acts.items()}
        yield spectrum_name(one.record), 3.0, partial(_spectra, one, acts)
    if pictures.stretch:
        yield STRETCH_NAME, 3.6, partial(_stretch, pictures.stretch, WITH_EFFECTS if pictures.acts else NEAREST)


def _spectra(one: ResidualSpectra, acts: Mapping[str, Sequence[float]], figure: Any) -> None:
    """Draw residual spectra before and after on logarithmic axes, with effects as areas and the noise dashed."""
    axes, f = figure.subplots(), one.frequency_hz
    low, high = one.noise / BELOW_NOISE, 2.0 * float(max(one.before.max(), one.after.max()))
    names = sorted(one.shares, key=lambda name: -float(one.shares[name].max()))
    # More effects than colours: the smallest ones share the last colour.
    colours = {name: SHARES[min(k, len(SHARES) - 1)] for k, name in enumerate(names)}
    for name in names:
        share = np.maximum(one.shares[name], FAINTEST * low)
        axes.fill_between(f, low, share, color=colours[name], alpha=0.25, linewidth=0.0)
        axes.plot(f, share, color=colours[name], linewidth=0.8, label=f"share of {name}")
    axes.plot(f, one.before, color=RESIDUAL_COLOUR, linewidth=1.1, label=f"residual, {AS_WRITTEN}")
    # Without an effect both models are the same, and the second curve would hide the first.
    if not np.array_equal(one.before, one.after):
        words = WITH_EFFECTS if names else NEAREST
        axes.plot(f, one.after, color=EFFECT, linewidth=0.8, label=f"residual, {words}")
    axes.axhline(one.noise, color=NOISE, linewidth=1.0, linestyle="--", label="noise floor")
    axes.set(xscale="log", yscale="log", xlim=(f[0], f[-1]), ylim=(low, high))
    axes.set(xlabel=FREQUENCY, ylabel=axis_labels(one.quantity)[DENSITY])
    in_powers(axes.xaxis)
    in_powers(axes.yaxis)
    _mark(axes, [(hz, colours[name]) for name in names for hz in acts.get(name, ())])
    _legend_above(figure, axes)


def _mark(axes: Any, places: Sequence[tuple[float, str]]) -> None:
    """Mark frequencies with their number at the upper edge if there is room; the table lists all of them."""
    low, high = axes.get_xlim()
    # On a logarithmic axis the width of a label is a ratio of frequencies.
    room = (high / low) ** (LABEL_IN / (WIDTH_IN - LEFT_IN - RIGHT_IN))
    free_from = [low] * LABEL_ROWS
    for hz, colour in sorted(places):
        axes.axvline(hz, color=colour, linewidth=0.7, linestyle=":", zorder=0)
        row = next((k for k, free in enumerate(free_from) if free <= hz), None)
        if row is not None:
            free_from[row] = hz * room
            axes.annotate(
                hertz(hz),
                (hz, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(2, -2 - 8 * row),
                textcoords="offset points",
                va="top",
                color=INK,
                fontsize=7,
            )


def _legend_above(figure: Any, *axes: Any) -> None:
    """Draw the legend above the axes, with enough space."""
    entries = [a.get_legend_handles_labels() for a in axes]
    handles, labels = ([one for entry in entries for one in entry[k]] for k in (0, 1))
    rows = -(-len(labels) // LEGEND_COLUMNS)
    figure.subplots_adjust(top=1.0 - (TOP_IN + LEGEND_ROW_IN * rows) / figure.get_figheight())
    place = {"loc": "upper right", "bbox_to_anchor": (1.0 - RIGHT_IN / WIDTH_IN, 1.0), "borderaxespad": 0.2}
    figure.legend(handles, labels, ncols=LEGEND_COLUMNS, fontsize=7.0, **place)


def _stretch(one: Stretch, words_after: str, figure: Any) -> None:
    """Draw measurement and models before and after, above their residuals."""
    labels = axis_labels(one.quantity)
    base = TimeBase(one.sample_rate_hz, one.measured.size, one.start_s)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2], gridspec_kw={"hspace": 0.08})
    over_time(above, reduce_to_extremes(one.measured, base), MEASURED, 2.2, "measured")
    is_same = np.array_equal(one.before, one.after)
    for modelled, colour, left, words in (
        (one.before, MODELLED, RESIDUAL_COLOUR, AS_WRITTEN),
        (one.after, EFFECT, EFFECT, words_after),
    )[: 1 if is_same else 2]:
        over_time(above, reduce_to_extremes(modelled, base), colour, 0.9, f"modelled, {words}")
        over_time(below, reduce_to_extremes(one.measured - modelled, base), left, 0.9, f"residual, {words}")
    above.set_ylabel(labels[TORQUE])
    below.set(xlabel=TIME, ylabel=labels[RESIDUAL])
    below.set_xlim(one.start_s, one.start_s + (one.measured.size - 1) / one.sample_rate_hz)
    figure.align_ylabels([above, below])
    _legend_above(figure, above, below)
