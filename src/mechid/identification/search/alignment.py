"""Alignment of the first motion of model and record, where the record's trigger delay scatters.

The mechanism oscillates with a period of about 20 ms. A start that is correct except for 20 ms of trigger scatter
therefore costs as much as any wrong start. The first motion reveals the delay before anything is fitted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from mechid.arrays import FloatArray
from mechid.identification.output_error.misfit import Window, misfit_series_of
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.search.first_moments import robust_costs
from mechid.identification.search.rest import commanded_first_step, hum_from_rest, motion_start, rest_window
from mechid.identification.search.settings import SEARCH

SHIFT_STEP = 5
"""Spacing of the delays that are compared, in samples: 0.5 ms at 10 kHz, close enough for the derivatives to converge.
"""


def align_first_motion(problem: Problem, target: Target, points: Sequence[FloatArray]) -> list[FloatArray]:
    """Return the points with the delay of one target set so that the model first moves when the record does.

    The model is simulated with the delay at which the file starts. If it does not move within a first window after the
    first commanded step, that step counts as its motion. All points are returned unchanged if the delay is known to
    within the rest that a first window includes, or if the target does not show a rest followed by motion.

    Parameters
    ----------
    problem : Problem
    target : Target
    points : sequence of (n,)
        Points with the file's delay of the target.
    """
    delay, measured = target.time_offset, _scattered_motion(target)
    if measured is None or not points:
        return list(points)
    place = problem.coordinates.names.index(delay.name)
    aligned = np.array(points)
    aligned[:, place] += (measured - np.array(_model_moves(problem, target, points))) * target.base.interval_s
    aligned[:, place] = np.clip(aligned[:, place], delay.min, delay.max)
    return list(aligned)


def align_all_first_motions(problem: Problem, q: FloatArray) -> FloatArray:
    """Return a point with the delays of all targets aligned, starting from the file's delays."""
    for target in problem.targets:
        (q,) = align_first_motion(problem, target, [q])
    return q


def realign(problem: Problem, q: FloatArray) -> FloatArray:
    """Return a point at which each scattered delay is the best one for the first motion of its record.

    Microsteps of a slow sweep are a tenth of a second apart. Friction and noise decide which of them is the first
    visible one, so a motion may have been aligned with the wrong microstep, and no derivative leads back from there.
    Once the mechanism is nearly known, the cost alone determines the delay within its bounds. The delay at `q` is
    replaced only if another one costs at most `SEARCH.realigned_share` as much.
    """
    for target in problem.targets:
        moves = _scattered_motion(target)
        if moves is not None:
            place = problem.coordinates.names.index(target.time_offset.name)
            later = _best_shift(problem, target, q, moves)
            q = q.copy()
            q[place] += later / target.base.sample_rate_hz
    return q


def _scattered_motion(target: Target) -> int | None:
    """Return the sample at which a target leaves its rest.

    None if the delay is known to within the rest that a first window includes, or if no motion after a rest is visible.
    """
    delay = target.time_offset
    if not delay.is_free or delay.max - delay.min <= SEARCH.lead_s:
        return None
    moves = motion_start(target, SEARCH.longest_rest_s)
    is_seen = target.burn_in + SEARCH.floor_s * target.base.sample_rate_hz <= moves < target.samples
    return moves if is_seen else None


def _best_shift(problem: Problem, target: Target, q: FloatArray, moves: int) -> int:
    """Return the best change of a target's delay within its bounds, in samples."""
    rate, delay = target.base.sample_rate_hz, target.time_offset
    now = problem.coordinates.value(delay, q)
    least, most = math.ceil((delay.min - now) * rate), math.floor((delay.max - now) * rate)
    first = moves - round(SEARCH.lead_s * rate)
    window = first, min(first + round(SEARCH.realigned_s * rate), target.samples)
    read: Window = max(window[0] - most, 0), min(window[1] - least, target.samples)
    (rooms,) = misfit_series_of(problem.model, target, [q], read)
    # The present delay, shift 0, is always among the candidates, so that a new delay is compared with it.
    shifts = np.unique([*range(least, most + 1, SHIFT_STEP), 0])
    costs = np.zeros(shifts.size)
    for channel, room in zip(target.channels, rooms, strict=True):
        modelled = room[:] + channel.measured[read[0] : read[1]]
        before, behind = max(read[0] - (window[0] - most), 0), max(window[1] - least - read[1], 0)
        # The model is at rest before the record begins, and is not simulated beyond its end.
        padded = np.pad(modelled, (before, behind), mode="edge")
        starts = most - shifts
        rows = sliding_window_view(padded, window[1] - window[0])[starts] - channel.measured[window[0] : window[1]]
        rows += hum_from_rest(channel, rest_window(target), window)
        rows /= channel.sigma
        if channel.linear:
            rows -= np.median(rows, axis=1, keepdims=True)
        # Rejected samples are zeroed last, because the subtractions above would make them count again.
        rows[:, channel.rejected_within(window)] = 0.0
        costs += robust_costs(rows)
    best = int(np.argmin(costs))
    is_better = costs[best] <= SEARCH.realigned_share * costs[np.searchsorted(shifts, 0)]
    return int(shifts[best]) if is_better else 0


def _model_moves(problem: Problem, target: Target, points: Sequence[FloatArray]) -> list[int]:
    """Return the sample at which the model leaves its rest at each point, by the threshold of the measured motion.

    Some mechanisms move when their command begins, before its first step, because the coils hold them out of
    equilibrium.
    """
    rate, step = target.base.sample_rate_hz, commanded_first_step(target)
    begins = math.floor((target.time_offset.value + target.command.origin_s - target.base.start_s) * rate) - 1
    window: Window = max(begins, 0), min(step + round(SEARCH.first_window_s * rate), target.samples)
    if window[0] >= window[1]:
        return [step] * len(points)
    moves = []
    for rooms in misfit_series_of(problem.model, target, points, window):
        first = window[1]
        for channel, room in zip(target.channels, rooms, strict=True):
            modelled = room[:] + channel.measured[window[0] : window[1]]
            moving = np.abs(modelled - modelled[0]) > SEARCH.moves * channel.sigma
            first = min(first, window[0] + int(np.argmax(moving))) if moving.any() else first
        moves.append(first if first < window[1] else step)
    return moves
