"""Figures on paper, made with Matplotlib, two columns wide; `palette` defines the colours.

Text remains text in the SVG, so that it can be searched and edited. Curves differ in line style and width as well as in
colour.
"""

from __future__ import annotations

import gc
import io
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import get_font_names
from matplotlib.ticker import FuncFormatter, NullLocator

from mechid.arrays import FloatArray
from mechid.writing import atomic_file

WIDTH_IN = 6.9
"""Width of a figure in inches: both columns of a paper."""
# A layout engine would double the drawing time.
LEFT_IN, RIGHT_IN, BELOW_IN, ABOVE_IN, BAR_IN = 0.68, 0.18, 0.42, 0.28, 0.58
"""Margins in inches."""
DOTS_AN_INCH = 200
# Only the last font, which Matplotlib ships, has all glyphs.
FONTS = ("Helvetica", "Arial", "Liberation Sans", "DejaVu Sans")
"""Fonts in order of preference, searched for each glyph."""
STYLE: Any = {
    "font.family": [*(name for name in FONTS if name in get_font_names()), "sans-serif"],
    "font.sans-serif": [*FONTS],
    "font.size": 8.0,
    "axes.labelsize": 8.0,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "grid.linewidth": 0.4,
    "grid.alpha": 0.4,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "lines.linewidth": 0.8,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "svg.fonttype": "none",
    # Without a fixed salt, the identifiers in the SVG of an equal figure would differ from run to run.
    "svg.hashsalt": "mechid",
    "path.simplify": True,
}
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
Drawing = Callable[[Any], None]


def write_figures(figures: Iterable[tuple[str, Figure]], folder: Path) -> dict[str, str]:
    """Write each figure as SVG and PNG, and return the SVG texts by name.

    Each file is written under a temporary name and renamed.

    Raises
    ------
    OSError
        The folder is not writable.
    """
    folder.mkdir(parents=True, exist_ok=True)
    texts = {}
    # Existing objects are excluded, so that the collections below cover only the figures.
    gc.freeze()
    for name, figure in figures:
        texts[name] = write_figure(name, figure, folder)
        # The caller may still hold the figure.
        figure.clear()
        # The parts of a figure reference one another; without a collection those of a report take 50 MB.
        gc.collect()
    gc.unfreeze()
    return texts


def write_figure(name: str, figure: Figure, folder: Path) -> str:
    """Write a figure as SVG and PNG; return the SVG text."""
    svg, png = io.BytesIO(), io.BytesIO()
    with mpl.rc_context(STYLE):
        figure.savefig(svg, format="svg", metadata={"Date": None, "Title": name, "Creator": "mechid"})
        figure.savefig(png, format="png", dpi=DOTS_AN_INCH, pil_kwargs={"compress_level": 4})
    for suffix, content in (("svg", svg), ("png", png)):
        with atomic_file(folder / f"{name}.{suffix}") as beside:
            beside.write_bytes(content.getvalue())
    return svg.getvalue().decode("utf-8")


def make_figure(draw: Drawing, height: float) -> Figure:
    """Make a figure of a height in inches, two columns wide, with the content drawn by `draw`."""
    figure = Figure(figsize=(WIDTH_IN, height))
    # A canvas of its own replaces pyplot, which would keep every figure in memory.
    FigureCanvasAgg(figure)
    figure.subplots_adjust(
        left=LEFT_IN / WIDTH_IN, right=1.0 - RIGHT_IN / WIDTH_IN, bottom=BELOW_IN / height, top=1.0 - ABOVE_IN / height
    )
    draw(figure)
    return figure


def over_time(axes: Any, points: FloatArray, colour: str, width: float, label: str) -> None:
    """Draw times in s and samples, (2, n)."""
    axes.plot(*points, color=colour, linewidth=width, label=label)


def legend_above(figure: Any, axes: Any, columns: int, **style: Any) -> None:
    """Draw the legend above the axes, at the right; `style` are legend options of Matplotlib."""
    place = {"loc": "upper right", "bbox_to_anchor": (1.0 - RIGHT_IN / WIDTH_IN, 1.0), "borderaxespad": 0.3}
    figure.legend(*axes.get_legend_handles_labels(), ncols=columns, **place, **style)


def in_powers(axis: Any) -> None:
    """Label a logarithmic axis with powers of ten as plain text, which is a hundred times faster than mathtext."""
    axis.set_major_formatter(FuncFormatter(power_of_ten))
    axis.set_minor_locator(NullLocator())


def power_of_ten(value: float, _: int | None = None) -> str:
    """Return the nearest power of ten as text.

    Examples
    --------
    >>> power_of_ten(0.001), power_of_ten(10.0)
    ('10⁻³', '10¹')
    """
    return "10" + str(round(math.log10(value))).translate(SUPERSCRIPT) if value > 0.0 else ""
