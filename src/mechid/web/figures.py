"""Figures of the page: one slot per record, and the progress of a fit; their parts are found by name."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from bokeh.models import BasicTickFormatter, ColumnDataSource, NumeralTickFormatter, Range1d

from mechid.arrays import FloatArray, IntArray
from mechid.ink.palette import series
from mechid.ink.quantities import AMPLITUDE, FREQUENCY, RESIDUAL, TIME, TORQUE, quantity_words
from mechid.reports.plots import empty_plot, hover_on, stack_axes
from mechid.signal.envelope import envelope
from mechid.units import unit_words
from mechid.web.picture import Effect, Picture, Scene

COLUMNS = 300
"""Columns of a picture; each shows the minimum and the maximum of a curve."""
OVER_TIME = ("measured", "modelled", "residual", "estimate")
SPECTRA = ("frequency", "residual spectrum", "measured spectrum", "modelled spectrum", "estimate spectrum")
"""Columns of a slot's source: curves over time, each with its own times, and curves over the frequency."""
LEFT = 68
"""Left border of all plots in pixels, which aligns their axes."""
MARGIN = 0.02
TORQUE_HEIGHT, RESIDUAL_HEIGHT, EFFECT_HEIGHT, SPECTRUM_HEIGHT, RUN_HEIGHT, PLACES_HEIGHT = 230, 130, 130, 230, 170, 270
LEAST_RESIDUAL, LEAST_EFFECT = 5.0, 0.1
"""Least height of the axes of residual and effect, in multiples of the noise of the record."""
TINY = 1e-15
ROUND = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
EFFECT = "effect, N m"
REPORTS, OVER_NOISE, PLACE = "reports of the fit", "residual over noise floor", "place between its ends"
FEWEST_REPORTS = 10.0
LABEL_GAP = 0.05
Course = Sequence[tuple[int, float]]
"""Pairs of report number and value."""


class Slot:
    """Figures of one shown record: torque, residual and effect on one time axis, and the spectrum.

    All curves except the effect are columns of one source, padded to one length, so that a picture is sent as one
    message and drawn at once. The page explains the colours, since Bokeh's legends took half of the drawing time.
    """

    def __init__(self, number: int) -> None:
        self.time = Range1d(start=0.0, end=1.0)
        self.frequency = Range1d(start=0.0, end=1.0)
        self.curves = ColumnDataSource({name: [] for name in (*OVER_TIME, *map(times_of, OVER_TIME), *SPECTRA)})
        self.effect = ColumnDataSource({"time": [], "effect": []})
        self.orders = ColumnDataSource({"x": [], "name": []})
        self.heights = {name: Range1d(start=-1.0, end=1.0) for name in ("torque", "residual", "effect")}
        self.heights["spectrum"] = Range1d(start=1e-6, end=1.0)
        self.axes: dict[str, Any] = {}
        self.estimate_lines: list[Any] = []
        self.roots = {f"time_{number}": self._time_plots(), f"spectrum_{number}": self._spectrum_plot()}
        for name, root in self.roots.items():
            root.name = name

    def _time_plots(self) -> Any:
        labels = {
            "torque": (TORQUE, TORQUE_HEIGHT),
            "residual": (RESIDUAL, RESIDUAL_HEIGHT),
            "effect": (EFFECT, EFFECT_HEIGHT),
        }
        plots = {
            name: empty_plot(
                TIME, label, height=height, x_range=self.time, y_range=self.heights[name], min_border_left=LEFT
            )
            for name, (label, height) in labels.items()
        }
        for name in ("measured", "modelled", "estimate"):
            self._line(plots["torque"], times_of(name), name)
        self._line(plots["residual"], times_of("residual"), "residual")
        plots["effect"].line("time", "effect", source=self.effect, name="effect", line_width=1.0)
        for plot in plots.values():
            tips = [("time", "$snap_x{0.000000} s"), ("value", "$y{0.000000}")]
            plot.add_tools(hover_on(list(plot.renderers), tips))
            plot.yaxis.formatter = BasicTickFormatter(power_limit_low=-6)
        self.axes = {"": plots["torque"].yaxis, "residual": plots["residual"].yaxis, "effect": plots["effect"].yaxis}
        plots["torque"].xaxis.visible = plots["residual"].xaxis.visible = False
        return stack_axes(list(plots.values()))

    def _spectrum_plot(self) -> Any:
        plot = empty_plot(
            FREQUENCY,
            AMPLITUDE,
            height=SPECTRUM_HEIGHT,
            y_axis_type="log",
            x_range=self.frequency,
            y_range=self.heights["spectrum"],
            min_border_left=LEFT,
        )
        marked = plot.vspan(x="x", source=self.orders, name="order", line_width=1, line_dash="dashed")
        lines = [self._line(plot, "frequency", name) for name in SPECTRA[1:]]
        tips = [("frequency", "@frequency{0.0} Hz"), ("amplitude", "$y{0.000000}")]
        plot.add_tools(hover_on(lines, tips), hover_on([marked], [("line", "@name at @x{0.0} Hz")]))
        self.axes["amplitude"] = plot.yaxis
        return plot

    def _line(self, plot: Any, over: str, name: str) -> Any:
        width = 2.4 if name.startswith("measured") else 1.0
        dash = "dashed" if name.startswith("estimate") else "solid"
        line = plot.line(over, name, source=self.curves, name=name, line_width=width, line_dash=dash, line_join="bevel")
        if name.startswith("estimate"):
            self.estimate_lines.append(line)
        return line

    def frame(self, picture: Picture, scene: Scene) -> None:
        """Set the axes to the whole picture of a channel, and mark the orders of its step rate and named lines."""
        end = picture.start_s + (picture.measured.size - 1) * picture.interval_s
        self.time.update(start=picture.start_s, end=end, reset_start=picture.start_s, reset_end=end)
        top = scene.shown_hz
        self.frequency.update(start=0.0, end=top, reset_start=0.0, reset_end=top)
        marked = [(hz, name) for name, each in scene.marked_hz.items() for hz in each if hz <= top]
        self.orders.data = {"x": [hz for hz, _ in marked], "name": [name for _, name in marked]}
        quantity, unit = quantity_words(scene.match.quantity), unit_words(scene.match.quantity)
        for words, axis in self.axes.items():
            axis.axis_label = f"{words or quantity}, {unit}"

    @property
    def view(self) -> tuple[float, float]:
        """Visible range of the time axis in s of record time."""
        ends: Any = self.time.start, self.time.end
        return float(ends[0]), float(ends[1])

    def show(self, picture: Picture, estimate: Picture | None) -> None:
        """Draw a record with the model, and optionally the curves of the estimate."""
        nothing: FloatArray = np.empty(0)
        own = [picture.measured, picture.modelled, picture.residual, estimate.modelled if estimate else nothing]
        spectra = [picture.residual_spectrum, picture.measured_spectrum, picture.modelled_spectrum]
        spectra.append(estimate.modelled_spectrum if estimate else nothing)
        columns: dict[str, FloatArray] = dict(zip(SPECTRA, [picture.frequency_hz, *spectra], strict=True))
        for name, y in zip(OVER_TIME, own, strict=True):
            kept = self._visible_samples(picture, y)
            columns[times_of(name)] = np.asarray(picture.start_s + kept * picture.interval_s, dtype=np.float64)
            columns[name] = y[kept]
        for line in self.estimate_lines:
            line.visible = estimate is not None
        self.curves.data = pad_columns(columns)
        self._set_heights(picture)

    def show_effect(self, picture: Picture, effect: Effect) -> None:
        """Draw the effect of a small step of the active knob."""
        kept = self._visible_samples(picture, effect.torque)
        self.effect.data = {"time": picture.start_s + kept * picture.interval_s, "effect": effect.torque[kept]}
        height = round_up(max(largest(effect.torque), LEAST_EFFECT * picture.numbers.residual.noise_sigma))
        hold(self.heights["effect"], -height, height)

    def _visible_samples(self, picture: Picture, y: FloatArray) -> IntArray:
        """Return the visible samples to draw: the extremes of each column, or all if they are few."""
        # Separate samples for each curve: with common ones a curve would need up to three times as many points.
        start, end = self.view
        margin = MARGIN * (end - start)
        first = max(int((start - margin - picture.start_s) / picture.interval_s), 0)
        last = min(int((end + margin - picture.start_s) / picture.interval_s) + 2, y.size)
        return first + envelope(y[first : max(last, first)], COLUMNS)

    def _set_heights(self, picture: Picture) -> None:
        noise = picture.numbers.residual.noise_sigma
        torque = round_up(largest(picture.measured, picture.modelled))
        residual = round_up(max(largest(picture.residual), LEAST_RESIDUAL * noise))
        for name, height in (("torque", torque), ("residual", residual)):
            hold(self.heights[name], -height, height)
        top = largest(picture.measured_spectrum, picture.modelled_spectrum)
        line = max(noise / math.sqrt(picture.measured.size), 1e-9 * top)
        hold(self.heights["spectrum"], 10.0 ** math.floor(math.log10(line)), 10.0 ** math.ceil(math.log10(top)))


class RunFigures:
    """Progress of a fit: noise ratios of the worst and the median record, and each parameter in its range."""

    def __init__(self) -> None:
        self.reports = Range1d(start=0.0, end=FEWEST_REPORTS)
        self.ratios = Range1d(start=0.5, end=10.0)
        self.noise = {name: ColumnDataSource({"x": [], "y": []}) for name in ("worst", "median")}
        self.places = ColumnDataSource({"xs": [], "ys": [], "name": [], "colour": []})
        self.ends = ColumnDataSource({"x": [], "y": [], "symbol": [], "colour": []})
        root = self._plots()
        root.name = "run"
        self.roots = {"run": root}

    def _plots(self) -> Any:
        noise = empty_plot(
            REPORTS, OVER_NOISE, height=RUN_HEIGHT, y_axis_type="log", x_range=self.reports, y_range=self.ratios
        )
        noise.hspan(y=[1.0], name="noise", line_width=1.2, line_dash="dashed")
        points = []
        for name, source in self.noise.items():
            noise.line("x", "y", source=source, name=name, line_width=1.6)
            points.append(noise.scatter("x", "y", source=source, name=f"{name} points", size=4))
        noise.add_tools(hover_on(points, [("report", "@x"), (OVER_NOISE, "@y{0.00}")]))
        noise.yaxis.formatter = NumeralTickFormatter(format="0.[00]a")
        places = empty_plot(REPORTS, PLACE, height=PLACES_HEIGHT, x_range=self.reports)
        places.y_range = Range1d(start=-0.03, end=1.03)
        curves = places.multi_line(
            "xs", "ys", source=self.places, name="places", line_width=1.6, line_color="colour", hover_line_width=3
        )
        places.text(
            "x",
            "y",
            text="symbol",
            source=self.ends,
            text_font_size="11px",
            text_color="colour",
            text_baseline="middle",
            x_offset=6,
        )
        tips = [("parameter", "@name"), ("place", "$y{0.000}")]
        hover = hover_on([curves], tips)
        hover.tooltips = tips
        places.add_tools(hover)
        for plot in (noise, places):
            plot.min_border_left = LEFT
        noise.xaxis.visible = False
        return stack_axes([noise, places])

    def show(self, ratios: Mapping[str, Course], places: Mapping[str, Course], symbols: Mapping[str, str]) -> None:
        """Draw the noise ratios of the worst and the median record, and each parameter, over the reports."""
        names = [name for name, course in places.items() if course]
        ends = [own[-1][0] for own in (*ratios.values(), *places.values()) if own]
        self.reports.end = max(1.1 * max(ends, default=1), FEWEST_REPORTS)
        drawn = [ratio for own in ratios.values() for _, ratio in own]
        if drawn:
            self.ratios.update(start=min(0.8, 0.8 * min(drawn)), end=max(2.0, 1.25 * max(drawn)))
        for name, own in ratios.items():
            self.noise[name].data = {"x": [k for k, _ in own], "y": [ratio for _, ratio in own]}
        colours = [series(k) for k in range(len(names))]
        self.places.data = {
            "xs": [[k for k, _ in places[name]] for name in names],
            "ys": [[y for _, y in places[name]] for name in names],
            "name": names,
            "colour": colours,
        }
        self.ends.data = {
            "x": [places[name][-1][0] for name in names],
            "y": spread_labels([places[name][-1][1] for name in names], LABEL_GAP),
            "symbol": [symbols[name] for name in names],
            "colour": colours,
        }


def hold(axis: Range1d, low: float, high: float) -> None:
    """Set the ends of an axis only if they changed, which keeps a zoom of the user."""
    if (axis.reset_start, axis.reset_end) != (low, high):
        axis.update(start=low, end=high, reset_start=low, reset_end=high)


def spread_labels(places: Sequence[float], gap: float) -> list[float]:
    """Return label heights near `places`, in the same order and at least `gap` apart.

    Examples
    --------
    >>> spread_labels([0.5, 0.1, 0.52], 0.1)
    [0.5, 0.1, 0.6]
    """
    heights = list(places)
    below = -math.inf
    for k in sorted(range(len(heights)), key=heights.__getitem__):
        below = heights[k] = round(max(heights[k], below + gap), 9)
    return heights


def times_of(name: str) -> str:
    """Return the name of the column with the times of a curve."""
    return f"{name} at"


def pad_columns(columns: Mapping[str, Any]) -> dict[str, FloatArray]:
    """Pad columns with NaN to a common length."""
    size = max(y.size for y in columns.values())
    return {name: np.pad(y, (0, size - y.size), constant_values=np.nan) for name, y in columns.items()}


def largest(*curves: FloatArray) -> float:
    """Return the largest finite magnitude of the curves, at least a tiny value."""
    found = [float(np.abs(y[np.isfinite(y)]).max(initial=0.0)) for y in curves]
    return max(*found, TINY)


def round_up(value: float) -> float:
    """Round up to one of a few round numbers, so that an axis changes rarely.

    Examples
    --------
    >>> round_up(0.73), round_up(0.0021), round_up(1.0)
    (0.8, 0.003, 1.0)
    """
    decade = 10.0 ** math.floor(math.log10(value))
    return float(f"{next(step for step in ROUND if step * decade >= value * (1.0 - 1e-9)) * decade:.1e}")
