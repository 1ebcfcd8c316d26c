"""The interactive figures, made with Bokeh: one of each kind, without data, for a page's script to fill.

A figure of Bokeh's takes some 50 ms to make, and all records have the same ones; so each kind is made once and
the page shows it as often as there are channels of records; for those that are no torque the script writes other
units. Sources, ranges and renderers have names by which the script
finds them; colours are the page's, light or dark.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from importlib.resources import files
from typing import Any, TypeAlias

from bokeh.embed import json_item
from bokeh.layouts import gridplot
from bokeh.models import ColumnDataSource, HoverTool, LogColorMapper, LogTicker, Range1d
from bokeh.models.annotations import ColorBar, Legend
from bokeh.palettes import Cividis256
from bokeh.plotting import figure

from mechid.ink.quantities import AMPLITUDE, CORRELATION, DENSITY, FREQUENCY, LAG, RESIDUAL, TIME, TORQUE

Item: TypeAlias = dict[str, Any]
SCRIPTS = ("bokeh.min.js",)
TORQUE_HEIGHT, RESIDUAL_HEIGHT, HEIGHT = 280, 170, 280
FONT = "system-ui, sans-serif"


def plot_items() -> dict[str, Item]:
    """Return each kind of figure as BokehJS embeds it, by name."""
    kinds = {
        "torque": _torque,
        "spectrum": _spectrum,
        "density": _density,
        "correlation": _correlation,
        "spectrogram": _spectrogram,
    }
    return {name: dict(json_item(make())) for name, make in kinds.items()}


def library() -> str:
    """Return BokehJS, a script."""
    folder = files("bokeh").joinpath("server", "static", "js")
    return "\n".join(folder.joinpath(name).read_text(encoding="utf-8") for name in SCRIPTS)


def _torque() -> Any:
    """Measured and modelled torque over their residual, on one time axis."""
    time = Range1d(start=0.0, end=1.0, name="time")
    above = empty_plot(TIME, TORQUE, height=TORQUE_HEIGHT, x_range=time)
    below = empty_plot(TIME, RESIDUAL, height=RESIDUAL_HEIGHT, x_range=time)
    curves = [add_curve(above, name) for name in ("measured", "modelled")]
    residual = add_curve(below, "residual")
    add_legend(above, curves)
    for plot, lines in ((above, curves), (below, [residual])):
        plot.add_tools(hover_on(lines, [("time", "@x{0.000000} s"), ("torque", "@y{0.000000} N m")]))
    # Both plots share a time axis, which the lower one labels.
    above.xaxis.visible = False
    return stack_axes([above, below])


def _spectrum() -> Any:
    """Amplitude spectra with the orders of the step rate, or the resonances of a sweep."""
    plot = empty_plot(FREQUENCY, AMPLITUDE, y_axis_type="log", x_range=Range1d(start=0.0, end=1.0, name="frequency"))
    plot.y_range = Range1d(start=1e-6, end=1.0, name="amplitude")
    for name in ("order", "resonance"):
        source = ColumnDataSource({"x": [], "y": [], "label": []}, name=f"{name} marks")
        plot.vspan(x="x", source=source, name=name, line_width=1, line_dash="dashed")
        plot.text(
            x="x",
            y="y",
            text="label",
            source=source,
            name=f"{name} label",
            text_font={"value": FONT},
            text_font_size="11px",
            text_baseline="top",
            x_offset=3,
        )
    # The residual is drawn first, beneath the other lines; the legend names it last.
    curves = [add_line(plot, name) for name in ("residual", "measured", "modelled")]
    add_legend(plot, [curves[1], curves[2], curves[0]])
    plot.add_tools(hover_on(curves, [("frequency", "@x{0.0} Hz"), ("amplitude", "@y{0.000000} N m")]))
    return plot


def _density() -> Any:
    """Power density of the residual beside that of the record's noise floor."""
    plot = empty_plot(FREQUENCY, DENSITY, x_axis_type="log", y_axis_type="log")
    plot.y_range = Range1d(start=1e-6, end=1.0, name="density")
    curves = [add_line(plot, name) for name in ("residual", "noise")]
    add_legend(plot, curves, {"noise": "noise floor"})
    plot.add_tools(hover_on(curves[:1], [("frequency", "@x{0.0} Hz"), ("density", "@y{0.00e+0} N m/√Hz")]))
    return plot


def _correlation() -> Any:
    """Autocorrelation of the residual, and the limits of a white one."""
    plot = empty_plot(LAG, CORRELATION)
    plot.yaxis.formatter.use_scientific = False
    source = ColumnDataSource({"x": [], "y": []}, name="residual data")
    bars = plot.vbar(x="x", top="y", width=0.7, source=source, name="residual bars", line_color=None)
    limit = ColumnDataSource({"y": []}, name="limit")
    spans = plot.hspan(y="y", source=limit, name="noise", line_dash="dashed")
    add_legend(plot, [bars, spans], {"residual bars": "residual", "noise": "95 % limits of white noise"})
    plot.add_tools(hover_on([bars], [("lag", "@x"), ("autocorrelation", "@y{0.0000}")]))
    return plot


def _spectrogram() -> Any:
    """Amplitude over time and frequency, measured above modelled, with order lines and resonances."""
    time, frequency = Range1d(start=0.0, end=1.0, name="time"), Range1d(start=0.0, end=1.0, name="frequency")
    mapper = LogColorMapper(palette=Cividis256, low=1e-4, high=1.0, name="colours")
    plots = [_image(which, mapper, time, frequency) for which in ("measured", "modelled")]
    plots[1].add_layout(amplitude_bar(mapper), "below")
    # Room for the colour bar, so that both images keep the same height.
    plots[1].height += 60
    return stack_axes(plots)


def amplitude_bar(mapper: LogColorMapper) -> ColorBar:
    """Return the scale of a spectrogram's colours."""
    return ColorBar(
        color_mapper=mapper,
        title=AMPLITUDE,
        ticker=LogTicker(),
        height=10,
        title_text_font_style="normal",
        title_text_font=FONT,
        major_label_text_font=FONT,
    )


def _image(which: str, mapper: LogColorMapper, time: Range1d, frequency: Range1d) -> Any:
    plot = empty_plot(TIME, f"{which}: {FREQUENCY}", x_range=time)
    plot.y_range = frequency
    source = ColumnDataSource({"image": [], "x": [], "y": [], "dw": [], "dh": []}, name=f"{which} image")
    plot.image("image", x="x", y="y", dw="dw", dh="dh", source=source, color_mapper=mapper)
    lines = ColumnDataSource({"x": [], "y": []}, name=f"{which} orders")
    order = plot.multi_line("x", "y", source=lines, name="order over", line_dash="dashed", line_width=1, line_alpha=0.6)
    spans = ColumnDataSource({"y": []}, name=f"{which} resonances")
    resonance = plot.hspan(y="y", source=spans, name="resonance over", line_dash="dotted", line_width=1.5)
    if which == "measured":
        names = {"order over": "orders ½, 1, 2, 3, 4 of the step rate", "resonance over": "resonances"}
        add_legend(plot, [order, resonance], names)
    plot.grid.visible = False
    return plot


def empty_plot(x_label: str, y_label: str, *, height: int = HEIGHT, **more: Any) -> Any:
    """Return a figure as wide as its place, its axes labelled, without curves."""
    plot = figure(
        height=height,
        sizing_mode="stretch_width",
        min_width=200,
        tools="pan,box_zoom,reset,save",
        active_drag="box_zoom",
        toolbar_location="above",
        x_axis_label=x_label,
        y_axis_label=y_label,
        output_backend="canvas",
        **more,
    )
    plot.toolbar.logo = None
    plot.axis.axis_label_text_font_style = "normal"
    plot.axis.axis_label_text_font = plot.axis.major_label_text_font = FONT
    plot.axis.axis_label_text_font_size = "13px"
    plot.axis.major_label_text_font_size = "12px"
    return plot


def add_curve(plot: Any, name: str) -> Any:
    """Add a line whose samples show as points where there is room for them."""
    line = add_line(plot, name)
    # The page's script shows the points once few samples are in view.
    plot.scatter("x", "y", source=line.data_source, size=4, name=f"{name} samples", visible=False)
    return line


def add_line(plot: Any, name: str) -> Any:
    """Add a line over an empty source; both are found by the name."""
    source = ColumnDataSource({"x": [], "y": []}, name=f"{name} data")
    # The model is drawn over the measurement and would cover a line of the same width.
    width = 2.4 if name == "measured" else 1.2
    return plot.line("x", "y", source=source, name=name, line_width=width, line_join="round")


def hover_on(renderers: list[Any], tips: list[tuple[str, str]]) -> HoverTool:
    """Return a tool that tells the name and values of a curve under the pointer."""
    return HoverTool(renderers=renderers, tooltips=[("", "$name"), *tips], mode="mouse", line_policy="nearest")


def add_legend(plot: Any, renderers: Iterable[Any], words: dict[str, str] | None = None) -> None:
    """Add a legend above a figure; a click hides a curve."""
    named = partial((words or {}).get)
    items = [(named(r.name) or r.name, [r]) for r in renderers]
    legend = Legend(
        items=items,
        orientation="horizontal",
        click_policy="hide",
        label_text_font=FONT,
        ncols="auto",
        label_text_font_size="12px",
        border_line_color=None,
        spacing=14,
        margin=0,
    )
    plot.add_layout(legend, "above")


def stack_axes(plots: list[Any]) -> Any:
    """Return figures one above the other with one toolbar."""
    options: Any = {"logo": None, "active_drag": None}
    rows: Any = [[plot] for plot in plots]
    return gridplot(
        rows, sizing_mode="stretch_width", merge_tools=True, toolbar_location="above", toolbar_options=options
    )
