"""Figure of quantities over time in strips, one below the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.ink.palette import MEASURED, ORDER, series
from mechid.ink.quantities import TIME

LEFT_SHARE = 0.14
STRIP_IN, AROUND_IN = 1.3, 0.7
"""Height of a strip, and total height of the margins above and below, in inches."""
RATE = "rate,\nfull steps/s"


@dataclass(frozen=True)
class Strip:
    """A quantity over time.

    Attributes
    ----------
    label : str
    points : (2, n)
        Times in s, and values.
    colour : str
    marked : sequence of (float, float)
        Marked time ranges in s.
    width : float
        Line width in points.
    """

    label: str
    points: FloatArray
    colour: str = MEASURED
    marked: Sequence[tuple[float, float]] = ()
    width: float = 0.7


def rate_strip(rate: FloatArray, ends: tuple[float, float]) -> Strip:
    """Return the strip of a commanded rate, (R, 2) of s and full steps/s, constant for R = 1."""
    points = rate.T if len(rate) > 1 else np.array([ends, [rate[0, 1]] * 2])
    return Strip(RATE, points, series(1), width=1.0)


def strips_height(count: int) -> float:
    """Return the height in inches of a figure with some strips."""
    return STRIP_IN * count + AROUND_IN


def draw_strips(title: str, strips: Sequence[Strip], ends: tuple[float, float], figure: Any) -> None:
    """Draw strips with a common time axis."""
    figure.subplots_adjust(left=LEFT_SHARE)
    axes = figure.subplots(len(strips), 1, sharex=True, squeeze=False, gridspec_kw={"hspace": 0.12})[:, 0]
    for ax, strip in zip(axes, strips, strict=True):
        ax.plot(*strip.points, color=strip.colour, linewidth=strip.width)
        for span in strip.marked:
            ax.axvspan(*span, color=ORDER, alpha=0.4, linewidth=0.0)
        ax.set_ylabel(strip.label)
    axes[0].set_title(title, fontsize=8.0, loc="left")
    axes[-1].set_xlabel(TIME)
    axes[-1].set_xlim(*ends)
    figure.align_ylabels(axes)
