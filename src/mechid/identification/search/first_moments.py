"""The first moments of a record's motion: the window of 60 ms in which starts are judged, and its robust cost."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.misfit import Model, Window, misfit_series_of
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.search.settings import SEARCH


def first_window(target: Target) -> Window:
    """Return the first window that counts, in samples.

    It begins behind the burn-in. Where it would end before the record has moved for 15 ms, it begins 5 ms before the
    motion instead: a rest costs the same at every start. The motion is what the channels show, wherever the command is
    said to begin. Where they are never at rest, as under hum, or show nothing, it is the first step commanded.
    """
    rate, first = target.base.sample_rate_hz, target.burn_in
    moves = motion_begins(target, SEARCH.longest_rest_s)
    if not _is_late(target, moves):
        step = _first_step(target)
        moves = step if _is_late(target, step) and _is_quiet_before(target, step) else first
    if moves > first:
        first = moves - round(SEARCH.lead_s * rate)
    return first, min(target.samples, first + round(SEARCH.first_window_s * rate))


def _is_late(target: Target, moves: int) -> bool:
    """Tell whether a motion begins too late for the window behind the burn-in, and early enough to be simulated."""
    rest_s = (moves - target.burn_in) / target.base.sample_rate_hz
    return SEARCH.first_window_s - SEARCH.floor_s < rest_s <= SEARCH.longest_rest_s and moves < target.samples


def _first_step(target: Target) -> int:
    """Return the sample at which the command makes its first step; all samples where it makes none."""
    steps = target.excitation.times
    if not steps.size:
        return target.samples
    after_s = float(steps[0]) + target.command.origin_s + target.time_offset.value - target.base.start_s
    return min(max(math.ceil(after_s * target.base.sample_rate_hz), 0), target.samples)


def _is_quiet_before(target: Target, step: int) -> bool:
    """Tell whether all channels move much less in the window behind the burn-in than in the one from a step on."""
    size = round(SEARCH.first_window_s * target.base.sample_rate_hz)
    return all(
        np.var(c.measured[target.burn_in : target.burn_in + size])
        < SEARCH.quiet * np.var(c.measured[step : step + size])
        for c in target.channels
    )


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


def first_samples(target: Target) -> int:
    """Return how many samples the first window has."""
    first, stop = first_window(target)
    return stop - first


def first_residual(problem: Problem, target: Target, q: FloatArray) -> FloatArray:
    """Return the residuals of a target's channels over the first window, in sigmas, without their medians."""
    return np.asarray(first_residuals(problem.model, target, [q])[0])


def first_residuals(
    model: Model, target: Target, points: Sequence[FloatArray], window: Window | None = None
) -> FloatArray:
    """Return the same at several points, one at least, over the first window or another: a row each."""
    window = window or first_window(target)
    rooms = misfit_series_of(model, target, points, window)
    each = []
    for channel, series in zip(target.channels, zip(*rooms, strict=True), strict=True):
        rows = np.stack([room[:] for room in series])
        rows /= channel.sigma
        if channel.linear:
            rows -= np.median(rows, axis=1, keepdims=True)
        rows[:, channel.rejected_within(window)] = 0.0
        each.append(rows)
    return each[0] if len(each) == 1 else np.concatenate(each, axis=1)


def robust_cost(residual: FloatArray) -> float:
    """Return the soft-L1 cost at `SEARCH.robust_sigmas`; inf where the simulation failed."""
    return float(robust_costs(residual[np.newaxis])[0])


def robust_costs(residuals: FloatArray) -> FloatArray:
    """Return that of each row."""
    with np.errstate(over="ignore", invalid="ignore"):  # what grew beyond all numbers failed too
        square = (residuals / SEARCH.robust_sigmas) ** 2
        costs = 2.0 * SEARCH.robust_sigmas**2 * np.sum(square / (1.0 + np.sqrt(1.0 + square)), axis=1)
    return np.where(np.isfinite(costs), costs, math.inf)
