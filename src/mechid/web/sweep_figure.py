"""Spectrograms of one record: measurement, model and residual with a common colour scale."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, HoverTool, LogColorMapper, Range1d
from bokeh.palettes import Cividis256

from mechid.ink.quantities import AMPLITUDE, FREQUENCY, TIME, axis_labels
from mechid.reports.plots import amplitude_bar, empty_plot, stack_axes
from mechid.web.figures import LEFT, hold, largest, round_up
from mechid.web.picture import Scene
from mechid.web.sweep import SweepPicture

IMAGES = ("measured", "modelled", "residual")
HEIGHT, AXIS_HEIGHT, BAR_HEIGHT = 190, 42, 60
# Long gaps keep the data below the marks visible.
GAPS = [3, 11]
"""Lengths of dashes and gaps in pixels."""
RANGE = 3000.0
"""Ratio of the largest to the smallest amplitude of the colour scale, as in the report."""


class SweepFigure:
    """Three images on common axes, with orders of the step rate and resonances."""

    def __init__(self, number: int) -> None:
        self.time, self.frequency = Range1d(start=0.0, end=1.0), Range1d(start=0.0, end=1.0)
        self.images = ColumnDataSource({name: [] for name in (*IMAGES, "x", "y", "dw", "dh")})
        self.orders = ColumnDataSource({"x": [], "y": []})
        self.resonances = ColumnDataSource({"y": []})
        self.colours = LogColorMapper(palette=Cividis256, low=1e-4, high=1.0)
        self.bar = amplitude_bar(self.colours)
        plots = [self._image(name) for name in IMAGES]
        for plot in plots[:-1]:
            plot.xaxis.visible = False
        plots[-1].add_layout(self.bar, "below")
        plots[-1].height += AXIS_HEIGHT + BAR_HEIGHT
        self.root = stack_axes(plots)
        self.root.name = f"spectrogram_{number}"
        self.frequency.name = f"frequency_{number}"

    def _image(self, name: str) -> Any:
        plot = empty_plot(
            TIME, f"{name}: {FREQUENCY}", height=HEIGHT, x_range=self.time, y_range=self.frequency, min_border_left=LEFT
        )
        image = plot.image(name, x="x", y="y", dw="dw", dh="dh", source=self.images, color_mapper=self.colours)
        plot.multi_line("x", "y", source=self.orders, name="order over", line_dash=GAPS, line_width=1, line_alpha=0.8)
        plot.hspan(y="y", source=self.resonances, name="resonance over", line_dash=GAPS, line_width=1.5)
        tips = [("", name), ("time", "$x{0.00} s"), ("frequency", "$y{0} Hz"), ("amplitude", f"@{name}{{0.000000}}")]
        plot.add_tools(HoverTool(renderers=[image], tooltips=tips))
        plot.grid.visible = False
        return plot

    def show(self, sweep: SweepPicture, scene: Scene) -> None:
        """Draw a stretch of a record, with axes and colours limited to round values."""
        columns, bins = sweep.measured.shape[1], sweep.measured.shape[0]
        half = 0.5 * (sweep.time_s[-1] - sweep.time_s[0]) / max(columns - 1, 1)
        start, end = float(sweep.time_s[0]), float(sweep.time_s[-1])
        self.images.data = {name: [getattr(sweep, name).astype(np.float32)] for name in IMAGES} | {
            "x": [start - half],
            "dw": [end - start + 2.0 * half],
            "y": [sweep.lowest_hz],
            "dh": [bins * sweep.row_hz],
        }
        times, rates = sweep.rate[:, 0], np.abs(sweep.rate[:, 1])
        self.orders.data = {"x": [times] * len(sweep.orders), "y": [order * rates for order in sweep.orders]}
        self.resonances.data = {"y": [r.frequency_hz for r in sweep.resonances]}
        hold(self.time, start, end)
        hold(self.frequency, 0.0, sweep.tops_hz[0])
        high = round_up(largest(sweep.measured))
        self.colours.update(low=high / RANGE, high=high)
        self.bar.title = axis_labels(scene.match.quantity)[AMPLITUDE]
