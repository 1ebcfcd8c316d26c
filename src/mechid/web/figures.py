"""The figures of the page: one slot a record, and the run of a fit. Their parts are found by name."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, DataRange1d, Range1d
from numpy.typing import NDArray

from mechid.report.plots import (
    AMPLITUDE,
    FREQUENCY,
    RESIDUAL,
    TIME,
    TORQUE,
    add_legend,
    add_line,
    empty_plot,
    hover_on,
    stacked,
)
from mechid.signal import envelope
from mechid.web.picture import Effect, Picture

FloatArray = NDArray[np.float64]
COLUMNS = 600
"""Of a curve over time; each holds its least and its largest sample."""
MARGIN = 0.02
TORQUE_HEIGHT, RESIDUAL_HEIGHT, EFFECT_HEIGHT, SPECTRUM_HEIGHT, RUN_HEIGHT = 230, 130, 130, 230, 200
EFFECT = "effect, N m"
PLACE = "place between the ends"


class Slot:
    """The figures of one record that is shown: torque, residual and effect on one time axis, and the spectrum."""

    def __init__(self, number: int) -> None:
        self.time = Range1d(start=0.0, end=1.0)
        self.frequency = Range1d(start=0.0, end=1.0)
        self.sources: dict[str, ColumnDataSource] = {}
        self.roots = {f"time_{number}": self._over_time(), f"spectrum_{number}": self._spectrum()}
        for name, root in self.roots.items():
            root.name = name

    def _over_time(self) -> Any:
        torque = empty_plot(TIME, TORQUE, height=TORQUE_HEIGHT, x_range=self.time)
        residual = empty_plot(TIME, RESIDUAL, height=RESIDUAL_HEIGHT, x_range=self.time)
        effect = empty_plot(TIME, EFFECT, height=EFFECT_HEIGHT, x_range=self.time)
        lines = [self._line(torque, "time", name) for name in ("measured", "modelled", "estimate")]
        lines[2].glyph.line_dash = "dashed"
        add_legend(torque, lines, {"estimate": "last estimate"})
        self._line(residual, "time", "residual")
        self._line(effect, "time", "effect")
        torque.xaxis.visible = residual.xaxis.visible = False
        for plot in (torque, residual, effect):
            plot.min_border_left = 68
            plot.add_tools(hover_on(list(plot.renderers), [("time", "@x{0.000000} s"), ("torque", "@y{0.000000} N m")]))
        return stacked([torque, residual, effect])

    def _spectrum(self) -> Any:
        plot = empty_plot(
            FREQUENCY, AMPLITUDE, height=SPECTRUM_HEIGHT, y_axis_type="log", x_range=self.frequency, y_range=DataRange1d()
        )
        plot.min_border_left = 68
        marks = ColumnDataSource({"x": []})
        plot.vspan(x="x", source=marks, name="order", line_width=1, line_dash="dashed")
        self.sources["orders"] = marks
        lines = [self._line(plot, "spectrum", name) for name in ("residual", "measured", "modelled", "estimate")]
        lines[3].glyph.line_dash = "dashed"
        plot.y_range.renderers = lines[1:3]
        add_legend(plot, [lines[1], lines[2], lines[3], lines[0]], {"estimate": "last estimate"})
        plot.add_tools(hover_on(lines, [("frequency", "@x{0.0} Hz"), ("amplitude", "@y{0.000000} N m")]))
        return plot

    def _line(self, plot: Any, kind: str, name: str) -> Any:
        line = add_line(plot, name)
        self.sources[f"{kind} {name}"] = line.data_source
        return line

    def frame(self, picture: Picture, shown_hz: float, orders: list[float]) -> None:
        """Set the axes to a whole picture, and mark the orders of its step rate, Hz."""
        end = picture.start_s + (picture.measured.size - 1) * picture.interval_s
        self.time.update(start=picture.start_s, end=end, reset_start=picture.start_s, reset_end=end)
        self.frequency.update(start=0.0, end=shown_hz, reset_start=0.0, reset_end=shown_hz)
        self.sources["orders"].data = {"x": [hz for hz in orders if hz <= shown_hz]}

    def show(self, picture: Picture) -> None:
        """Draw measured, modelled and residual torque and their spectra."""
        for name in ("measured", "modelled", "residual"):
            self._fill(f"time {name}", picture, getattr(picture, name))
            self._fill_spectrum(name, picture.frequency_hz, getattr(picture, f"{name}_spectrum"))

    def show_estimate(self, picture: Picture | None) -> None:
        """Draw the estimate's torque and spectrum, or none."""
        if picture is None:
            self.sources["time estimate"].data = {"x": [], "y": []}
            self.sources["spectrum estimate"].data = {"x": [], "y": []}
            return
        self._fill("time estimate", picture, picture.modelled)
        self._fill_spectrum("estimate", picture.frequency_hz, picture.modelled_spectrum)

    def show_effect(self, picture: Picture, effect: Effect) -> None:
        """Draw the change of the torque by a small step of the knob in hand."""
        self._fill("time effect", picture, effect.torque)

    def _fill(self, source: str, picture: Picture, y: FloatArray) -> None:
        """Draw the least and the largest sample of each column of what is in view, or every sample if they are few."""
        start, end = float(self.time.start), float(self.time.end)
        margin = MARGIN * (end - start)
        first = max(int((start - margin - picture.start_s) / picture.interval_s), 0)
        last = min(int((end + margin - picture.start_s) / picture.interval_s) + 2, y.size)
        part = y[first : max(last, first)]
        kept = first + envelope(part, COLUMNS)
        self.sources[source].data = {"x": picture.start_s + kept * picture.interval_s, "y": y[kept]}

    def _fill_spectrum(self, name: str, frequency: FloatArray, amplitude: FloatArray) -> None:
        self.sources[f"spectrum {name}"].data = {"x": frequency, "y": amplitude}


class RunFigures:
    """The course of a fit: its cost, and where each parameter stands between its ends."""

    def __init__(self) -> None:
        self.reports = DataRange1d(start=0.0)
        self.cost = ColumnDataSource({"x": [], "y": []})
        self.places = ColumnDataSource({"xs": [], "ys": [], "name": [], "symbol": []})
        self.ends = ColumnDataSource({"x": [], "y": [], "symbol": []})
        root = self._plots()
        root.name = "run"
        self.roots = {"run": root}

    def _plots(self) -> Any:
        cost = empty_plot("reports of the fit", "cost", height=RUN_HEIGHT, y_axis_type="log")
        line = cost.line("x", "y", source=self.cost, name="modelled", line_width=1.6)
        points = cost.scatter("x", "y", source=self.cost, name="modelled points", size=4)
        cost.add_tools(hover_on([line, points], [("report", "@x"), ("cost", "@y{0.0000}")]))
        places = empty_plot("reports of the fit", PLACE, height=RUN_HEIGHT + 40, x_range=cost.x_range)
        places.y_range = Range1d(start=-0.03, end=1.03)
        curves = places.multi_line("xs", "ys", source=self.places, name="measured places", line_width=1.6)
        places.text("x", "y", text="symbol", source=self.ends, name="residual symbols", text_font_size="11px",
                    text_baseline="middle", x_offset=4)  # fmt: skip
        places.add_tools(hover_on([curves], [("parameter", "@name"), ("place", "$y{0.000}")]))
        for plot in (cost, places):
            plot.min_border_left = 68
        return stacked([cost, places])

    def show(self, costs: list[tuple[int, float]], places: dict[str, list[tuple[int, float]]], symbols: dict[str, str]) -> None:
        """Draw the cost of each report that told one, and the place of each parameter over the reports."""
        self.cost.data = {"x": [k for k, _ in costs], "y": [c for _, c in costs]}
        names = [name for name, course in places.items() if course]
        self.places.data = {
            "xs": [[k for k, _ in places[name]] for name in names],
            "ys": [[y for _, y in places[name]] for name in names],
            "name": names,
            "symbol": [symbols[name] for name in names],
        }
        last = [places[name][-1] for name in names]
        self.ends.data = {"x": [k for k, _ in last], "y": [y for _, y in last], "symbol": [symbols[n] for n in names]}
