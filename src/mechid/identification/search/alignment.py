"""Delays of records whose trigger scatters, set so that the model first moves when the record does.

A start that is right but for 20 ms of a trigger's scatter costs as much as any other, since the mechanism oscillates
with about that period. The first motion shows the delay before anything is fitted.
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
from mechid.identification.search.rest import commanded_first_step, hum_from_rest, motion_begins, rest_of
from mechid.identification.search.settings import SEARCH

SHIFT_STEP = 5
"""Samples between delays that are compared: 0.5 ms at 10 kHz, from where the derivatives lead on."""


def align_first_motion(problem: Problem, target: Target, points: Sequence[FloatArray]) -> list[FloatArray]:
    """Return points whose delay of a target lets the model first move when the target does.

    The model is run with the delay that the file starts from. Where it does not move within a first window behind the
    first step commanded, that step counts as its motion. All points stay as they are where the delay is known to
    within the rest that a first window keeps, and where the target is not seen to rest, and then to move.

    Parameters
    ----------
    problem : Problem
    target : Target
    points : sequence of (n,)
        With the file's delay of the target.
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
    """Return a point with the file's delays after all targets are aligned."""
    for target in problem.targets:
        (q,) = align_first_motion(problem, target, [q])
    return q


def realign(problem: Problem, q: FloatArray) -> FloatArray:
    """Return a point at which each scattered delay is the one that explains the first motion of its record best.

    Microsteps of a slow sweep are a tenth of a second apart. Which of them is the first to be seen depends on friction
    and noise, so that a motion may have been aligned with the wrong one, from where no derivative leads back. Once the
    mechanism is nearly known the delay within its bounds is told by the cost alone. Another one than that at `q` is
    taken where it costs `SEARCH.realigned_share` of it at most.
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
    """Return the sample at which a target leaves its rest; None where its delay is known well enough, or none is seen.

    What a first window keeps of the rest is well enough.
    """
    delay = target.time_offset
    if not delay.is_free or delay.max - delay.min <= SEARCH.lead_s:
        return None
    moves = motion_begins(target, SEARCH.longest_rest_s)
    is_seen = target.burn_in + SEARCH.floor_s * target.base.sample_rate_hz <= moves < target.samples
    return moves if is_seen else None


def _best_shift(problem: Problem, target: Target, q: FloatArray, moves: int) -> int:
    """Return by how many samples the delay of a target is to be later, of those within its bounds."""
    rate, delay = target.base.sample_rate_hz, target.time_offset
    now = problem.coordinates.value(delay, q)
    least, most = math.ceil((delay.min - now) * rate), math.floor((delay.max - now) * rate)
    first = moves - round(SEARCH.lead_s * rate)
    window = first, min(first + round(SEARCH.realigned_s * rate), target.samples)
    read: Window = max(window[0] - most, 0), min(window[1] - least, target.samples)
    (rooms,) = misfit_series_of(problem.model, target, [q], read)
    shifts = np.unique([*range(least, most + 1, SHIFT_STEP), 0])
    costs = np.zeros(shifts.size)
    for channel, room in zip(target.channels, rooms, strict=True):
        modelled = room[:] + channel.measured[read[0] : read[1]]
        before, behind = max(read[0] - (window[0] - most), 0), max(window[1] - least - read[1], 0)
        padded = np.pad(modelled, (before, behind), mode="edge")  # at rest before, and no record is read beyond its end
        starts = most - shifts
        rows = sliding_window_view(padded, window[1] - window[0])[starts] - channel.measured[window[0] : window[1]]
        rows += hum_from_rest(channel, rest_of(target), window)
        rows /= channel.sigma
        if channel.linear:
            rows -= np.median(rows, axis=1, keepdims=True)
        rows[:, channel.rejected_within(window)] = 0.0
        costs += robust_costs(rows)
    best = int(np.argmin(costs))
    is_better = costs[best] <= SEARCH.realigned_share * costs[np.searchsorted(shifts, 0)]
    return int(shifts[best]) if is_better else 0


def _model_moves(problem: Problem, target: Target, points: Sequence[FloatArray]) -> list[int]:
    """Return the sample at which the model leaves its rest at each point, by the limit that the measured motion has.

    Some mechanisms move when their command begins, before its first step: the coils hold them off their balance.
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
