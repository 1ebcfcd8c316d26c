"""Rest of a record before its motion: its duration, and the mains hum that it shows."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.misfit import Window
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.search.settings import SEARCH
from mechid.signal.trend import Line, fit_line, waves_at


def motion_start(target: Target, within_s: float = math.inf) -> int:
    """Return the first sample after the burn-in at which a channel leaves its rest; the sample count if none does.

    Samples later than `within_s` after the burn-in are not read.
    """
    rate = target.base.sample_rate_hz
    least, window = max(int(SEARCH.floor_s * rate), 8), max(round(SEARCH.first_window_s * rate), 8)
    stop = target.samples if math.isinf(within_s) else min(target.samples, target.burn_in + round(within_s * rate) + 1)
    moves = min(first_motion(channel, (target.burn_in, stop), least, window) for channel in target.channels)
    return moves if moves < stop else target.samples


def first_motion(channel: TargetChannel, within: Window, least: int, block: int) -> int:
    """Return the first sample of a window at which a channel leaves the median of its first `least` samples.

    The end of the window is returned if it does not. The first `block` samples are read first, because most records
    move within them, then twice as many each time.
    """
    start, stop = within
    rest = float(np.median(channel.measured[start : min(start + least, stop)]))
    while start < stop:
        moving = np.abs(channel.measured[start : min(start + block, stop)] - rest) > SEARCH.moves * channel.sigma
        if moving.any():
            return start + int(np.argmax(moving))
        start, block = start + block, min(2 * block, SEARCH.block)
    return stop


def rest_window(target: Target) -> Window:
    """Return the samples at rest after the burn-in, without those that a late first window includes."""
    moves = motion_start(target, SEARCH.longest_rest_s)
    lead = round(SEARCH.lead_s * target.base.sample_rate_hz)
    return target.burn_in, max(moves - lead, target.burn_in) if moves < target.samples else target.burn_in


def commanded_first_step(target: Target) -> int:
    """Return the sample of the first commanded step with the file's delay; the sample count if there is none."""
    steps = target.excitation.times
    if not steps.size:
        return target.samples
    after_s = float(steps[0]) + target.command.origin_s + target.time_offset.value - target.base.start_s
    return min(max(math.ceil(after_s * target.base.sample_rate_hz), 0), target.samples)


def commanded_rest_window(target: Target) -> Window:
    """Return samples of the second half of the rest before the first commanded step.

    The range is empty for a record that begins in motion. Under hum, `rest_window` cannot see where the motion begins;
    with a free delay, the commanded step is uncertain too, and the range is empty. In the first half, a mechanism may
    still swing after it was switched on.
    """
    first = target.burn_in
    if target.begins_in_motion or target.time_offset.is_free:
        return first, first
    step = commanded_first_step(target)
    lead = round(SEARCH.lead_s * target.base.sample_rate_hz)
    stop = max(step - lead, first) if step < target.samples else first
    return (first + stop) // 2, stop


@lru_cache(maxsize=64)  # thousands of starts share one window, and the fit costs as much as a simulation
def hum_from_rest(channel: TargetChannel, rest: Window, window: Window) -> FloatArray:
    """Return a channel's hum over a window, (n,), in its SI unit, fitted to its rest together with offset and drift.

    Within 60 ms hum cannot be distinguished from motion, and treated as noise it would hide that a start explains the
    window. The result is zero if the channel has no hum, or rests for less than `SEARCH.hum_periods` of its slowest
    line.

    Parameters
    ----------
    channel : TargetChannel
    rest, window : (int, int)
        First and last-plus-one sample of the rest, and of the window, which lies after or within it.
    """
    if not channel.turns or not _shows_hum(channel, rest):
        return np.zeros(window[1] - window[0])
    resting = channel.measured[rest[0] : rest[1]]
    line = fit_line(resting, channel.linear, channel.rejected_within(rest), channel.turns)
    return Line(waves=line.waves).at(window[0] - rest[0], window[1] - rest[0])


def subtract_hum(
    channel: TargetChannel, rest: Window, window: Window, residuals: FloatArray, slopes: FloatArray | None = None
) -> None:
    """Subtract the hum of the rest from residuals over a window, (r, n), in place.

    If the rest does not show the hum, waves of its frequencies are projected out of the residuals and their slopes, (m,
    n). A window of the motion contains hum and motion together, so this removes some of the motion too.
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
    """Return an orthonormal basis of zero-mean waves, (samples, 2 k), at frequencies `turns` in turns a sample."""
    waves = np.array([row for pair in waves_at(turns, np.arange(samples)) for row in pair])
    return np.asarray(np.linalg.qr((waves - waves.mean(axis=1, keepdims=True)).T)[0])


def _shows_hum(channel: TargetChannel, rest: Window) -> bool:
    return (rest[1] - rest[0]) * min(channel.turns) >= SEARCH.hum_periods
