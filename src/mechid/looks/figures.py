"""Figures of a survey: each channel over time, over frequency, as a waterfall, in bands, and over the step rate."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from mechid.analysis.attributed_lines import AttributedLine
from mechid.analysis.look import ChannelLook, RecordLook, Waterfall
from mechid.analysis.order_tracking import ORDERS
from mechid.arrays import FloatArray
from mechid.ink.extremes import reduce_to_extremes
from mechid.ink.figures import BAR_IN, STYLE, WIDTH_IN, Drawing, in_powers, make_figure, over_time
from mechid.ink.palette import INK, MARK, MARK_OVER, MEASURED, NOISE, ORDER, series
from mechid.ink.quantities import FREQUENCY, TIME, quantity_words
from mechid.looks.words import order_name, unit_text
from mechid.records.channel_keys import channel_keys
from mechid.signal.envelope import peak_groups
from mechid.signal.runs import Runs
from mechid.signal.spectrogram import largest_rows

GROUPS, MOST_ROWS, MOST_MARKED, MOST_LABELS = 3000, 400, 200, 12
"""Largest numbers: groups of a spectrum, rows of a waterfall, marked gaps and lines, labelled lines."""
KINDS = ("time", "spectrum", "waterfall", "bands", "over_rate")
RATE = "step rate, full steps/s"
SHOWN_DECADES = 3.5
"""Decades of a waterfall's amplitude."""
ABOVE_RATE, ABOVE_RESONANCE, ABOVE_LINES = 4.5, 1.3, 1.2
"""Upper end of a waterfall, as multiples of the largest rate, the highest resonance, the highest larger line."""
LARGER = 0.03
"""Share of the largest line above which a line is one of the larger."""


def look_figures(looks: Sequence[RecordLook], kinds: Sequence[str] = KINDS) -> Iterator[tuple[str, Figure]]:
    """Yield the figures of each channel with their names, or only those of some kinds."""
    for look in looks:
        for key, channel in zip(channel_keys(look.record), look.channels, strict=True):
            drawings = (one for one in _drawings(look, channel) if one[0] in kinds)
            for name, height, draw in drawings:
                with mpl.rc_context(STYLE), np.errstate(all="ignore"):
                    figure = make_figure(draw, height)
                yield f"{key}_{name}", figure


def _drawings(look: RecordLook, channel: ChannelLook) -> Iterator[tuple[str, float, Drawing]]:
    yield "time", 2.2, partial(_time, look, channel)
    yield "spectrum", 2.6, partial(_spectrum, look, channel)
    yield "waterfall", 3.2, partial(_waterfall, channel)
    yield "bands", 2.4, partial(_bands, channel)
    if channel.over_rate:
        yield "over_rate", 2.6, partial(_over_rate, channel)


def axis_label(look: ChannelLook, of: str = "") -> str:
    """Return the axis label of a channel: the quantity, or a given name, and its unit."""
    unit = unit_text(look.channel.unit)
    return f"{of or quantity_words(look.channel.quantity)}{', ' if unit else ''}{unit}"


def _time(look: RecordLook, channel: ChannelLook, figure: Any) -> None:
    """Draw the least and the largest sample per column of the picture; mark gaps, quiet and clipped stretches."""
    axes, base = figure.subplots(), look.base
    for runs, colour, alpha in (
        (channel.gaps, ORDER, 0.5),
        (_quiet_runs(channel), NOISE, 0.2),
        (channel.clipped, series(1), 0.5),
    ):
        for first, stop in runs[:MOST_MARKED]:
            # A sample stands for half a sampling interval on both sides.
            span = [base.start_s + (k - 0.5) / base.sample_rate_hz for k in (first, stop)]
            axes.axvspan(*span, color=colour, alpha=alpha, linewidth=0.0)
    over_time(axes, reduce_to_extremes(channel.channel.data, base), MEASURED, 0.7, "measured")
    axes.set(xlabel=TIME, ylabel=axis_label(channel), xlim=(base.start_s, base.start_s + look.record.duration_s))


def _quiet_runs(channel: ChannelLook) -> Runs:
    return tuple((stretch.first, stretch.stop) for stretch in channel.quiet)


def _number(order: float) -> str:
    return order_name(order).removeprefix("order ")


def _label(seen: AttributedLine) -> str:
    """Return the order of a line, or its name in the mechanism; empty if it has none."""
    if seen.order is not None:
        return _number(seen.order)
    return seen.named[0].name if seen.named else ""


def spectrum_groups(channel: ChannelLook) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return frequency, amplitude and surrounding level, (M,) each: the largest per group of bins, and its median."""
    spectrum = channel.spectrum
    # A line must not disappear between the points of a figure: the largest bin of each group is kept.
    starts = peak_groups(spectrum.amplitude.size, GROUPS)
    middle = (starts + np.append(starts[1:], spectrum.amplitude.size) - 1) // 2
    amplitude = np.maximum.reduceat(spectrum.amplitude, starts)
    # The median of an exponentially distributed power is log(2) times its mean.
    return middle * spectrum.bin_hz, amplitude, np.sqrt(spectrum.level[middle] / math.log(2.0))


def _spectrum(look: RecordLook, channel: ChannelLook, figure: Any) -> None:
    """Draw the amplitude over the surrounding level, its lines, and the lines that the command would cause."""
    axes = figure.subplots()
    if look.declared and look.constant_rate:
        for order in sorted({*ORDERS, float(look.declared.command.microsteps)}):
            axes.axvline(order * look.constant_rate, color=MARK, linewidth=0.7, linestyle="--", alpha=0.5, zorder=0)
    frequency, amplitude, level = spectrum_groups(channel)
    axes.plot(frequency, amplitude, color=MEASURED, linewidth=0.7, label="amplitude")
    if np.any(level > 0.0):
        axes.plot(frequency, level, color=NOISE, linewidth=0.8, linestyle="--", label="level around")
    lines = sorted(channel.lines, key=lambda seen: -seen.line.amplitude)
    for k, seen in enumerate(lines[:MOST_MARKED]):
        label = _label(seen)
        colour = series(1) if seen.mains and not label else MARK if label else INK
        axes.plot(seen.line.frequency_hz, seen.line.amplitude, "o", color=colour, markersize=2.2)
        if k < MOST_LABELS and label:
            place = (seen.line.frequency_hz, seen.line.amplitude)
            axes.annotate(
                label,
                place,
                xytext=(0, 3),
                textcoords="offset points",
                ha="center",
                color=MARK,
                fontsize=7,
            )
    for found in channel.resonances:
        axes.axvspan(
            found.frequency_hz - found.spread_hz,
            found.frequency_hz + found.spread_hz,
            color=MARK,
            alpha=0.15,
            linewidth=0,
        )
    _in_decades(axes, amplitude)
    shown = level[(level > 0.0) & np.isfinite(level)]
    if shown.size:
        # Without a lower limit a single bin near zero would take most decades of the axis.
        axes.set_ylim(bottom=float(np.quantile(shown, 0.05)) / 3.0)
    axes.set(xlabel=FREQUENCY, ylabel=axis_label(channel, "amplitude"), xscale="log")
    axes.set_xlim(frequency[0], frequency[-1])
    in_powers(axes.xaxis)
    axes.legend(loc="upper right")


def _bands(channel: ChannelLook, figure: Any) -> None:
    """Draw the density next to the RMS in third octaves."""
    left, right = figure.subplots(1, 2, gridspec_kw={"wspace": 0.3})
    # The axes are logarithmic, and 0 Hz has no place on them.
    root, rms = np.sqrt(channel.density[1:]), np.array([band.rms for band in channel.bands])
    left.plot(channel.density_hz[1:], root, color=MEASURED, linewidth=0.6)
    # White noise has a constant one-sided density up to half the sample rate.
    white = channel.noise.sigma * math.sqrt(2.0 / channel.spectrum.sample_rate_hz)
    left.axhline(white, color=NOISE, linewidth=0.9, linestyle="--", label="white noise of the level found")
    unit = unit_text(channel.channel.unit)
    left.set(xlabel=FREQUENCY, ylabel=f"density, {unit or 'unit'}/√Hz", xscale="log")
    left.legend(loc="lower left")
    edges = [channel.bands[0].lower_hz, *(band.upper_hz for band in channel.bands)]
    right.stairs(rms, edges, color=MEASURED, fill=True)
    right.set(xlabel=FREQUENCY, ylabel=axis_label(channel, "RMS in third octaves"), xscale="log")
    for axes, values in ((left, root), (right, rms)):
        _in_decades(axes, values)
        in_powers(axes.xaxis)


def _in_decades(axes: Any, values: FloatArray) -> None:
    """Set a logarithmic scale if there are positive values."""
    if np.any((values > 0.0) & np.isfinite(values)):
        axes.set_yscale("log")
        in_powers(axes.yaxis)


def _waterfall(channel: ChannelLook, figure: Any) -> None:
    """Draw amplitude over frequency and time, or over the rate if it is known and monotonic."""
    w = channel.waterfall
    # At least four rows, below which there is no picture.
    kept = max(int(np.searchsorted(w.frequency_hz, _top_frequency(channel, w), side="right")), 4)
    each = math.ceil(kept / MOST_ROWS)
    rows = largest_rows(w.amplitude[:kept], each)
    # Each drawn row is placed in the middle of the rows that it combines; bin 1 is the spacing, as bin 0 is at 0 Hz.
    frequency = w.frequency_hz[: rows.shape[0] * each : each][: rows.shape[0]] + 0.5 * (each - 1) * w.frequency_hz[1]
    over = _waterfall_axis(w)
    figure.subplots_adjust(right=1.0 - BAR_IN / WIDTH_IN)
    axes = figure.subplots()
    # The lowest row holds the mean, which is no vibration and may exceed all else.
    high = float(np.nanmax(rows[1:])) or 1.0
    image = axes.pcolormesh(
        over[1],
        frequency,
        rows,
        norm=LogNorm(high / 10.0**SHOWN_DECADES, high),
        cmap="cividis",
        # As vectors, each cell would be an element of the SVG.
        rasterized=True,
        shading="nearest",
    )
    if np.all(np.isfinite(w.rate)) and float(np.ptp(w.rate)) > 0.0:
        for order in ORDERS:
            axes.plot(over[1], order * w.rate, "w--", linewidth=0.5, alpha=0.6)
    for found in channel.resonances:
        axes.axhline(found.frequency_hz, color=MARK_OVER, linewidth=0.8, linestyle=":")
    axes.set(xlabel=over[0], ylabel=FREQUENCY, ylim=(0.0, frequency[-1]), xlim=(over[1][0], over[1][-1]))
    axes.grid(visible=False)
    bar = figure.colorbar(image, ax=axes, label=axis_label(channel, "amplitude"), pad=0.02, fraction=0.06)
    in_powers(bar.ax.yaxis)


def _waterfall_axis(w: Waterfall) -> tuple[str, FloatArray]:
    """Return the label and the positions of a waterfall's columns."""
    step = np.diff(w.rate)
    monotonic = bool(np.all(np.isfinite(w.rate)) and (np.all(step > 0.0) or np.all(step < 0.0)))
    return (RATE, w.rate) if monotonic else (TIME, w.time_s)


def _top_frequency(channel: ChannelLook, w: Waterfall) -> float:
    """Return the highest frequency of interest, Hz."""
    rate = float(np.nanmax(w.rate)) if np.any(np.isfinite(w.rate)) else 0.0
    largest = max((seen.line.amplitude for seen in channel.lines), default=0.0)
    lines = [seen.line.frequency_hz for seen in channel.lines if seen.line.amplitude >= LARGER * largest]
    resonances = [found.frequency_hz for found in channel.resonances]
    wanted = max(
        ABOVE_RATE * rate, ABOVE_RESONANCE * max(resonances, default=0.0), ABOVE_LINES * max(lines, default=0.0)
    )
    return min(wanted or math.inf, float(w.frequency_hz[-1]))


def _over_rate(channel: ChannelLook, figure: Any) -> None:
    """Draw the amplitude of each order over the rate, with the noise subtracted."""
    axes = figure.subplots()
    orders = sorted({line.order for line in channel.over_rate})
    for k, order in enumerate(orders):
        lines = sorted((line for line in channel.over_rate if line.order == order), key=lambda line: line.rate)
        rate = [line.rate for line in lines]
        size = np.sqrt([max(line.power(), 0.0) for line in lines])
        axes.plot(rate, size, color=series(k), linewidth=0.9, label=_number(order))
    for found in channel.resonances:
        for order in found.orders:
            axes.axvline(found.frequency_hz / order, color=MARK, linewidth=0.6, linestyle=":")
    axes.set(xlabel=RATE, ylabel=axis_label(channel, "amplitude"))
    axes.margins(x=0.0)
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="upper left", ncols=3, title="order of the step rate", title_fontsize=7.5)
