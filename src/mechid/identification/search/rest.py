"""Mains hum in the first window of a record, as the rest before its motion shows it."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.misfit import Window
from mechid.identification.output_error.target import TargetChannel
from mechid.identification.search.settings import SEARCH
from mechid.signal.trend import Line, fit_line


@lru_cache(maxsize=64)  # thousands of starts are judged in one window, and the fit costs as much as a simulation
def hum_from_rest(channel: TargetChannel, rest: Window, window: Window) -> FloatArray:
    """Return a channel's hum over a window, (n,), in its SI unit: fitted to its rest together with offset and drift.

    In 60 ms hum cannot be told from motion, and as noise it would hide that a start explains the window. Zero where
    the channel has no hum, or rests for less than `SEARCH.hum_periods` of its slowest line.

    Parameters
    ----------
    channel : TargetChannel
    rest, window : (int, int)
        First and last-plus-one sample of the rest, and of the window, which lies behind or within it.
    """
    if not channel.turns or (rest[1] - rest[0]) * min(channel.turns) < SEARCH.hum_periods:
        return np.zeros(window[1] - window[0])
    resting = channel.measured[rest[0] : rest[1]]
    line = fit_line(resting, channel.linear, channel.rejected_within(rest), channel.turns)
    return Line(waves=line.waves).at(window[0] - rest[0], window[1] - rest[0])
