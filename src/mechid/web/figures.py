"""The figures of the page: one slot a record, and the run of a fit. Their parts are found by name."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from bokeh.models import BasicTickFormatter, ColumnDataSource, NumeralTickFormatter, Range1d
from numpy.typing import NDArray

from mechid.report.plots import (
    AMPLITUDE,
    FREQUENCY,
    RESIDUAL,
    TIME,
    TORQUE,
    empty_plot,
    hover_on,
    stacked,
)
from mechid.signal import envelope
from mechid.web.picture import Effect, Picture, Scene

FloatArray = NDArray[np.float64]
COLUMNS = 500
"""Of a picture; each holds the least and the largest sample of every curve."""
OVER_TIME = ("measured", "modelled", "residual", "effect", "estimate")
SPECTRA = ("residual", "measured", "modelled", "estimate")
LEFT = 68
"""Pixels left of all axes, so that they stand in line."""
MARGIN = 0.02
TORQUE_HEIGHT, RESIDUAL_HEIGHT, EFFECT_HEIGHT, SPECTRUM_HEIGHT, RUN_HEIGHT, PLACES_HEIGHT = 230, 130, 130, 230, 170, 270
LEAST_RESIDUAL, LEAST_EFFECT = 5.0, 0.1
"""Of a record's noise: the least height of the axes of residual and effect."""
TINY = 1e-15
ROUND = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
EFFECT = "effect, N m"
REPORTS, COST, PLACE = "reports of the fit", "cost a sample", "place between its ends"
FEWEST_REPORTS = 10.0
LABEL_GAP = 0.05
LINES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#8a8a8a", "#9467bd")
"""Okabe and Ito's, and two more: legible on light and dark."""
Course = Sequence[tuple[int, float]]
"""Number of a report, and a value."""


class Slot:
    """The figures of one record that is shown: torque, residual and effect on one time axis, and the spectrum.

    All curves over time are columns of one source, so that a picture is one message; all spectra of another. What the
    colours mean the page says: legends of Bokeh's own took half of the drawing.
    """

    def __init__(self, number: int) -> None:
        self.time = Range1d(start=0.0, end=1.0)
        self.frequency = Range1d(start=0.0, end=1.0)
        self.over_time = ColumnDataSource({name: [] for name in ("x", *OVER_TIME)})
        self.spectra = ColumnDataSource({name: [] for name in ("x", *SPECTRA)})
        self.orders = ColumnDataSource({"x": []})
        self.heights = {name: Range1d(start=-1.0, end=1.0) for name in ("torque", "residual", "effect")}
        self.heights["spectrum"] = Range1d(start=1e-6, end=1.0)
        self.limits: dict[str, tuple[float, float]] = {}
        self.axes: dict[str, Any] = {}
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
            self._line(plots["torque"], self.over_time, name)
        for name in ("residual", "effect"):
            self._line(plots[name], self.over_time, name)
        for plot in plots.values():
            tips = [("time", "@x{0.000000} s"), ("value", "@$name{0.000000}")]
            plot.add_tools(hover_on(list(plot.renderers), tips))
            plot.yaxis.formatter = BasicTickFormatter(power_limit_low=-6)
        self.axes = {"": plots["torque"].yaxis, "residual": plots["residual"].yaxis, "effect": plots["effect"].yaxis}
        plots["torque"].xaxis.visible = plots["residual"].xaxis.visible = False
        return stacked(list(plots.values()))

    def _spectrum_plot(self) -> Any:
        plot = empty_plot(FREQUENCY, AMPLITUDE, height=SPECTRUM_HEIGHT, y_axis_type="log", x_range=self.frequency,
                          y_range=self.heights["spectrum"], min_border_left=LEFT)  # fmt: skip
        plot.vspan(x="x", source=self.orders, name="order", line_width=1, line_dash="dashed")
        lines = [self._line(plot, self.spectra, name) for name in SPECTRA]
        tips = [("frequency", "@x{0.0} Hz"), ("amplitude", "@$name{0.000000}")]
        plot.add_tools(hover_on(lines, tips))
        self.axes["amplitude"] = plot.yaxis
        return plot

    @staticmethod
    def _line(plot: Any, source: ColumnDataSource, name: str) -> Any:
        width = 2.4 if name == "measured" else 1.2
        dash = "dashed" if name == "estimate" else "solid"
        return plot.line("x", name, source=source, name=name, line_width=width, line_dash=dash, line_join="round")

    def frame(self, picture: Picture, scene: Scene, orders: list[float]) -> None:
        """Set the axes to a whole picture of a channel, and mark the orders of its step rate, Hz."""
        end = picture.start_s + (picture.measured.size - 1) * picture.interval_s
        self.time.update(start=picture.start_s, end=end, reset_start=picture.start_s, reset_end=end)
        top = scene.shown_hz
        self.frequency.update(start=0.0, end=top, reset_start=0.0, reset_end=top)
        self.orders.data = {"x": [hz for hz in orders if hz <= top]}
        quantity, unit = scene.match.quantity.replace("_", " "), scene.unit.replace("*", " ")
        for words, axis in self.axes.items():
            axis.axis_label = f"{words or quantity}, {unit}"

    @property
    def view(self) -> tuple[float, float]:
        """Record time in s from and to which the axis runs, also zoomed."""
        ends: Any = self.time.start, self.time.end
        return float(ends[0]), float(ends[1])

    def show(self, picture: Picture, effect: Effect, estimate: Picture | None) -> None:
        """Draw a record beside the model, the effect of the knob in hand, and the estimate's curves where wanted."""
        curves = {
            "measured": picture.measured, "modelled": picture.modelled, "residual": picture.residual,
            "effect": effect.torque, "estimate": estimate.modelled if estimate else _none_like(picture.modelled),
        }  # fmt: skip
        kept = self._kept(picture, [y for name, y in curves.items() if name != "estimate" or estimate])
        times = picture.start_s + kept * picture.interval_s
        self.over_time.data = {"x": times, **{name: y[kept] for name, y in curves.items()}}
        self.spectra.data = {
            "x": picture.frequency_hz, "measured": picture.measured_spectrum, "modelled": picture.modelled_spectrum,
            "residual": picture.residual_spectrum,
            "estimate": estimate.modelled_spectrum if estimate else _none_like(picture.frequency_hz),
        }  # fmt: skip
        self._set_heights(picture, effect)

    def _kept(self, picture: Picture, curves: list[FloatArray]) -> NDArray[np.int64]:
        """Return the samples to draw of what is in view: the extremes of each column, or all if they are few."""
        start, end = self.view
        margin = MARGIN * (end - start)
        first = max(int((start - margin - picture.start_s) / picture.interval_s), 0)
        last = min(int((end + margin - picture.start_s) / picture.interval_s) + 2, picture.measured.size)
        parts = [first + envelope(y[first : max(last, first)], COLUMNS) for y in curves]
        return np.unique(np.concatenate(parts))

    def _set_heights(self, picture: Picture, effect: Effect) -> None:
        noise = picture.numbers.noise_sigma
        torque = round_up(largest(picture.measured, picture.modelled))
        residual = round_up(max(largest(picture.residual), LEAST_RESIDUAL * noise))
        moved = round_up(max(largest(effect.torque), LEAST_EFFECT * noise))
        for name, height in (("torque", torque), ("residual", residual), ("effect", moved)):
            self._hold(name, -height, height)
        top = largest(picture.measured_spectrum, picture.modelled_spectrum)
        line = max(noise / math.sqrt(picture.measured.size), 1e-9 * top)
        self._hold("spectrum", 10.0 ** math.floor(math.log10(line)), 10.0 ** math.ceil(math.log10(top)))

    def _hold(self, name: str, low: float, high: float) -> None:
        """Set an axis' ends where they are others than before, so that it stands still and a zoom is kept."""
        if self.limits.get(name) != (low, high):
            self.limits[name] = low, high
            self.heights[name].update(start=low, end=high, reset_start=low, reset_end=high)


class RunFigures:
    """The course of a fit: its cost, and where each parameter stands between its ends."""

    def __init__(self) -> None:
        self.reports = Range1d(start=0.0, end=FEWEST_REPORTS)
        self.costs = Range1d(start=0.1, end=10.0)
        self.cost = ColumnDataSource({"x": [], "y": []})
        self.places = ColumnDataSource({"xs": [], "ys": [], "name": [], "colour": []})
        self.ends = ColumnDataSource({"x": [], "y": [], "symbol": [], "colour": []})
        root = self._plots()
        root.name = "run"
        self.roots = {"run": root}

    def _plots(self) -> Any:
        cost = empty_plot(REPORTS, COST, height=RUN_HEIGHT, y_axis_type="log", x_range=self.reports, y_range=self.costs)
        line = cost.line("x", "y", source=self.cost, name="modelled", line_width=1.6)
        points = cost.scatter("x", "y", source=self.cost, name="modelled points", size=4)
        cost.add_tools(hover_on([line, points], [("report", "@x"), ("cost a sample", "@y{0.0000}")]))
        cost.yaxis.formatter = NumeralTickFormatter(format="0.[00]a")
        places = empty_plot(REPORTS, PLACE, height=PLACES_HEIGHT, x_range=self.reports)
        places.y_range = Range1d(start=-0.03, end=1.03)
        curves = places.multi_line(
            "xs", "ys", source=self.places, name="places", line_width=1.6, line_color="colour", hover_line_width=3
        )
        places.text("x", "y", text="symbol", source=self.ends, text_font_size="11px", text_color="colour",
                    text_baseline="middle", x_offset=6)  # fmt: skip
        tips = [("parameter", "@name"), ("place", "$y{0.000}")]
        hover = hover_on([curves], tips)
        hover.tooltips = tips
        places.add_tools(hover)
        for plot in (cost, places):
            plot.min_border_left = LEFT
        cost.xaxis.visible = False
        return stacked([cost, places])

    def show(self, costs: Course, places: Mapping[str, Course], symbols: Mapping[str, str]) -> None:
        """Draw the cost a sample of each report that told one, and the place of each parameter over the reports."""
        names = [name for name, course in places.items() if course]
        last = max([k for k, _ in costs] + [places[name][-1][0] for name in names], default=1)
        self.reports.end = max(1.1 * last, FEWEST_REPORTS)
        if costs:
            told = [c for _, c in costs]
            self.costs.update(start=0.8 * min(told), end=1.25 * max(told))
        self.cost.data = {"x": [k for k, _ in costs], "y": [c for _, c in costs]}
        colours = [LINES[k % len(LINES)] for k in range(len(names))]
        self.places.data = {
            "xs": [[k for k, _ in places[name]] for name in names],
            "ys": [[y for _, y in places[name]] for name in names],
            "name": names,
            "colour": colours,
        }
        self.ends.data = {
            "x": [places[name][-1][0] for name in names],
            "y": apart([places[name][-1][1] for name in names], LABEL_GAP),
            "symbol": [symbols[name] for name in names],
            "colour": colours,
        }


def apart(places: Sequence[float], gap: float) -> list[float]:
    """Return heights for labels near `places`, in the same order, each at least `gap` above the next lower.

    Examples
    --------
    >>> apart([0.5, 0.1, 0.52], 0.1)
    [0.5, 0.1, 0.6]
    """
    heights = list(places)
    below = -math.inf
    for k in sorted(range(len(heights)), key=heights.__getitem__):
        below = heights[k] = round(max(heights[k], below + gap), 9)
    return heights


def _none_like(y: FloatArray) -> FloatArray:
    return np.full(y.size, np.nan)


def largest(*curves: FloatArray) -> float:
    """Return the largest finite magnitude of some curves, or a tiny one where there is none."""
    found = [float(np.abs(y[np.isfinite(y)]).max(initial=0.0)) for y in curves]
    return max(*found, TINY)


def round_up(value: float) -> float:
    """Return the next of a few round numbers, so that an axis changes seldom.

    Examples
    --------
    >>> round_up(0.73), round_up(0.0021), round_up(1.0)
    (0.8, 0.003, 1.0)
    """
    decade = 10.0 ** math.floor(math.log10(value))
    return float(f"{next(step for step in ROUND if step * decade >= value * (1.0 - 1e-9)) * decade:.1e}")
