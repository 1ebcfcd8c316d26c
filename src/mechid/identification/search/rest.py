"""Rest of a record before its motion: how long it lasts, and the mains hum that it shows."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.misfit import Window
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.search.settings import SEARCH
from mechid.signal.trend import Line, fit_line, waves_at


def motion_begins(target: Target, within_s: float = math.inf) -> int:
    """Return the first sample behind the burn-in at which a channel leaves its rest; all samples where none does.

    Samples that come later than `within_s` behind the burn-in are not read.
    """
    rate = target.base.sample_rate_hz
    least, window = max(int(SEARCH.floor_s * rate), 8), max(round(SEARCH.first_window_s * rate), 8)
    stop = target.samples if math.isinf(within_s) else min(target.samples, target.burn_in + round(within_s * rate) + 1)
    moves = min(first_motion(channel, (target.burn_in, stop), least, window) for channel in target.channels)
    return moves if moves < stop else target.samples


def first_motion(channel: TargetChannel, within: Window, least: int, block: int) -> int:
    """Return the first sample of a window at which a channel leaves the median of its first `least` samples.

    The end of the window where it does not. The first `block` samples are read first, since most records move within
    them, then twice as many each time.
    """
    start, stop = within
    rest = float(np.median(channel.measured[start : min(start + least, stop)]))
    while start < stop:
        moving = np.abs(channel.measured[start : min(start + block, stop)] - rest) > SEARCH.moves * channel.sigma
        if moving.any():
            return start + int(np.argmax(moving))
        start, block = start + block, min(2 * block, SEARCH.block)
    return stop


def rest_of(target: Target) -> Window:
    """Return the samples behind the burn-in that are at rest, without those that a late first window keeps."""
    moves = motion_begins(target, SEARCH.longest_rest_s)
    lead = round(SEARCH.lead_s * target.base.sample_rate_hz)
    return target.burn_in, max(moves - lead, target.burn_in) if moves < target.samples else target.burn_in


def commanded_first_step(target: Target) -> int:
    """Return the sample at which the command makes its first step with the file's delay; all samples where none."""
    steps = target.excitation.times
    if not steps.size:
        return target.samples
    after_s = float(steps[0]) + target.command.origin_s + target.time_offset.value - target.base.start_s
    return min(max(math.ceil(after_s * target.base.sample_rate_hz), 0), target.samples)


def commanded_rest_of(target: Target) -> Window:
    """Return samples of the last half before the command's first step; none of a record that begins in motion.

    Hum hides from `rest_of` where the motion begins; a delay that is free hides it here. In the first half a mechanism
    may still swing, as it was switched on.
    """
    first = target.burn_in
    if target.begins_in_motion or target.time_offset.is_free:
        return first, first
    step = commanded_first_step(target)
    lead = round(SEARCH.lead_s * target.base.sample_rate_hz)
    stop = max(step - lead, first) if step < target.samples else first
    return (first + stop) // 2, stop


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
    if not channel.turns or not _shows_hum(channel, rest):
        return np.zeros(window[1] - window[0])
    resting = channel.measured[rest[0] : rest[1]]
    line = fit_line(resting, channel.linear, channel.rejected_within(rest), channel.turns)
    return Line(waves=line.waves).at(window[0] - rest[0], window[1] - rest[0])


def take_hum_away(
    channel: TargetChannel, rest: Window, window: Window, residuals: FloatArray, slopes: FloatArray | None = None
) -> None:
    """Take hum from residuals over a window, (r, n), in place: that of the rest.

    Where the rest shows none, what waves of its frequencies can explain goes from the residuals and their slopes,
    (m, n): a window of the motion tells hum and motion together, and less of either.
    """
    if not channel.turns:
        return
    residuals += hum_from_rest(channel, rest, window)
    if not _shows_hum(channel, rest):
        waves = _waves_of_hum(channel.turns, window[1] - window[0])
        residuals -= (residuals @ waves) @ waves.T
        if slopes is not None:
            slopes -= (slopes @ waves) @ waves.T


@lru_cache(maxsize=64)
def _waves_of_hum(turns: tuple[float, ...], samples: int) -> FloatArray:
    """Return an orthonormal basis of waves of so many turns a sample, less their means, (samples, 2 k)."""
    waves = np.array([row for pair in waves_at(turns, np.arange(samples)) for row in pair])
    return np.asarray(np.linalg.qr((waves - waves.mean(axis=1, keepdims=True)).T)[0])


def _shows_hum(channel: TargetChannel, rest: Window) -> bool:
    return (rest[1] - rest[0]) * min(channel.turns) >= SEARCH.hum_periods
