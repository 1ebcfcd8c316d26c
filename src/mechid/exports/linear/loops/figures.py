"""Figures of the loops of the electronics: Bode diagram with step response, and the trade of the notch."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from mechid.exports.linear.loops.bands import Band
from mechid.exports.linear.loops.loops import ClosedLoop, ClosedPosition, Loops
from mechid.ink.figures import STYLE, legend_above, make_figure
from mechid.ink.palette import LIMIT, series

LOOP_IN, TRADE_IN = 3.4, 2.6
HALF_TURN_DEG = 180.0
FAINT = 0.25
"""Opacity of a band."""

LoopFigure = tuple[str, str, Callable[[], Figure]]
"""Name, text alternative, and how it is drawn."""


def loop_figures(loops: Loops) -> Iterator[LoopFigure]:
    """Yield the figures of all loops."""
    for model, phases in loops.current.items():
        for phase, loop in phases.items():
            words = f"Current loop of {phase} around {model}: open loop and unit step, with the 95 % band"
            yield f"loop_current_{model}_{phase}", words, partial(_figure, partial(_loop, loop), LOOP_IN)
    for model, position in loops.position.items():
        words = f"Position loop around {model}: open loop and unit step, with the 95 % band"
        yield f"loop_position_{model}", words, partial(_figure, partial(_loop, position.closed), LOOP_IN)
        if any(choice.holding for choice in position.trade):
            words = f"Depth of the notch around {model}: stiffness and damping with the gains that the margins allow"
            yield f"loop_notch_{model}", words, partial(_figure, partial(_trade, position), TRADE_IN)


def _figure(draw: Callable[[Any], None], height: float) -> Figure:
    with mpl.rc_context(STYLE):
        return make_figure(draw, height)


def _loop(loop: ClosedLoop, figure: Any) -> None:
    """Draw magnitude and phase of the open loop at the left, the step response of each output at the right."""
    outputs = loop.step.outputs
    magnitude, phase = figure.add_subplot(2, 2, 1), figure.add_subplot(2, 2, 3)
    figure.subplots_adjust(wspace=0.28, hspace=0.12)
    numbers = loop.numbers
    # At half the sample rate the response is real, and its phase jumps by 180 deg.
    inside = slice(None, -1)
    for axes, band, label in ((magnitude, numbers.magnitude_dB, "dB"), (phase, numbers.phase_deg, "deg")):
        _band(axes, numbers.frequency_hz, band, 0, "open loop", inside)
        axes.set(xscale="log", ylabel=f"open loop, {label}")
    magnitude.axhline(0.0, color=LIMIT, linewidth=0.6, linestyle=":")
    magnitude.tick_params(labelbottom=False)
    phase.axhline(-HALF_TURN_DEG, color=LIMIT, linewidth=0.6, linestyle=":")
    phase.set_xlabel("frequency, Hz")
    if loop.sweep is not None:
        hertz = np.asarray(loop.sweep.frequency_hz)
        at = np.interp(np.log(hertz), np.log(numbers.frequency_hz), numbers.magnitude_dB.value)
        magnitude.plot(hertz, at, "o", markersize=2.5, color=LIMIT, label="checked by swept sines")
    for k, (name, band) in enumerate(outputs.items()):
        axes = figure.add_subplot(len(outputs), 2, 2 * (k + 1))
        _band(axes, loop.step.time_s, band, 1)
        axes.set_ylabel(name.replace("_", " "))
        axes.tick_params(labelbottom=k + 1 == len(outputs))
    axes.set_xlabel("time after a unit step, s")
    legend_above(figure, magnitude, 2)


def _band(axes: Any, x: Any, band: Band, number: int, label: str | None = None, inside: slice = slice(None)) -> None:
    axes.plot(x[inside], band.value[inside], color=series(number), label=label)
    axes.fill_between(x[inside], band.low[inside], band.high[inside], color=series(number), alpha=FAINT, linewidth=0.0)


def _trade(position: ClosedPosition, figure: Any) -> None:
    """Draw stiffness and damping over the depth of the notch, each with its gains at the limit of the margins."""
    chosen = [(choice.depth, choice.holding) for choice in position.trade if choice.holding]
    left, right = figure.subplots(1, 2)
    figure.subplots_adjust(wspace=0.28)
    # Without a notch the gain at its centre is 1.
    depth = np.array([1.0 if own is None else own for own, _ in chosen])
    for k, (axes, name, label) in enumerate(
        (
            (left, "stiffness", "stiffness, N m/rad"),
            (left, "least_stiffness", "least stiffness, N m/rad"),
            (right, "damping", "damping ratio of the drive-train mode"),
        )
    ):
        bands = [getattr(holding, name) for _, holding in chosen]
        band = Band(*(np.array([getattr(one, end) for one in bands]) for end in ("value", "low", "high")))
        _band(axes, depth, band, k, label.partition(",")[0])
        axes.plot(depth, band.value, "o", markersize=3.0, color=series(k))
    left.set(xscale="log", yscale="log", xlabel="gain at the notch's centre", ylabel="N m/rad")
    right.set(xscale="log", xlabel="gain at the notch's centre", ylabel="damping ratio of the mode")
    legend_above(figure, left, 2)
