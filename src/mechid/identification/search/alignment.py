"""Delays of records whose trigger scatters, set so that the model first moves when the record does.

A start that is right but for 20 ms of a trigger's scatter costs as much as any other, since the mechanism oscillates
with about that period. The first motion shows the delay before anything is fitted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.misfit import Window, misfit_series_of
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.search.first_moments import commanded_first_step, motion_begins
from mechid.identification.search.settings import SEARCH


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
    delay, rate = target.time_offset, target.base.sample_rate_hz
    if not points or not delay.is_free or delay.max - delay.min <= SEARCH.lead_s:
        return list(points)
    measured = motion_begins(target, SEARCH.longest_rest_s)
    if not target.burn_in + SEARCH.floor_s * rate <= measured < target.samples:
        return list(points)
    place = problem.coordinates.names.index(delay.name)
    aligned = np.array(points)
    aligned[:, place] += (measured - np.array(_model_moves(problem, target, points))) / rate
    aligned[:, place] = np.clip(aligned[:, place], delay.min, delay.max)
    return list(aligned)


def align_all_first_motions(problem: Problem, q: FloatArray) -> FloatArray:
    """Return a point with the file's delays after all targets are aligned."""
    for target in problem.targets:
        (q,) = align_first_motion(problem, target, [q])
    return q


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
