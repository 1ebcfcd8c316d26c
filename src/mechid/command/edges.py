"""Instants of the step edges, in closed form.

The profile is cut at its breakpoints, at the reversals and at t = 0 into pieces over which the
commanded position s(t), the integral of the rate, is monotonic. Over a piece s is a parabola,
so the instant at which it reaches a multiple of the step is the root of a quadratic.
Positions in this module are in steps of the command (1/n of a full step), as is the step index.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.command.rate import RateProfile
from mechid.errors import UsageError

MOST_EDGES = 20_000_000
"""Largest number of edges; more indicate a mistaken rate and would fill the computer's memory."""

FIRST, AT_ONCE = 1024, 65536
"""Edges computed per chunk: initially, and at most."""

SLACK = 8 * np.finfo(np.float64).eps
"""A position this close to a step, relative to peak rate times time, has reached it: the decimals of a
profile that stops on a step are rounded, and so is their sum."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """Pieces of a profile over which the rate is linear and keeps its sign; all arrays (P,).

    Times in s, rates in steps/s, positions in steps.
    """

    start_s: FloatArray
    duration_s: FloatArray
    start_rate: FloatArray
    end_rate: FloatArray
    start: FloatArray
    end: FloatArray

    @property
    def end_s(self) -> FloatArray:
        """End times in s, (P,)."""
        return self.start_s + self.duration_s

    @property
    def direction(self) -> FloatArray:
        """+1 where the position rises, -1 where it falls, 0 where it is constant, (P,)."""
        return np.sign(self.start_rate + self.end_rate)


def step_edges(profile: RateProfile, steps_per_full_step: int, duration_s: float) -> tuple[FloatArray, IntArray]:
    """Return the instants at which the step index changes, and the index from each instant on.

    The index is 0 at t = 0 and moves to k when the integral of the rate reaches k/n; touching k/n
    at a reversal counts as reaching it. From k it moves next at (k + 1)/n or (k - 1)/n, so that a
    command that oscillates about k/n does not chatter.

    Parameters
    ----------
    profile : RateProfile
        Commanded rate in full steps/s.
    steps_per_full_step : int
        n.
    duration_s : float
        Length of the interval from 0 in s; an edge exactly at its end counts.

    Returns
    -------
    times_s : (E,) float
        Instants in s, ascending.
    index : (E,) int
        Step index from that instant on; consecutive values differ by 1.

    Raises
    ------
    UsageError
        There are more edges than `MOST_EDGES`.
    """
    pieces = _pieces(profile, steps_per_full_step, duration_s)
    held = _held_index(pieces)
    stops = np.cumsum(np.abs(np.diff(held))).astype(np.int64)
    starts = np.concatenate([np.zeros(1, dtype=np.int64), stops])
    times, index = [np.empty(0)], [np.empty(0, dtype=np.int64)]
    first, at_once = 0, FIRST
    while first < starts[-1]:
        # Chunks double in size, so that a short record computes few edges in vain.
        number = np.arange(first, min(first + at_once, int(starts[-1])))
        piece = np.searchsorted(stops, number, side="right")
        reached = held[piece] + pieces.direction[piece] * (number - starts[piece] + 1)
        instants = _instants(pieces, piece, reached)
        # The end itself counts, however it is rounded.
        within = instants <= duration_s * (1.0 + SLACK)
        times.append(np.minimum(instants[within], duration_s))
        index.append(reached[within].astype(np.int64))
        if not within[-1]:
            # The last piece may extend far beyond the duration.
            break
        first, at_once = first + at_once, min(2 * at_once, AT_ONCE)
    return np.concatenate(times), np.concatenate(index)


def quantise_to_ticks(
    times_s: FloatArray, index: IntArray, tick_s: float, duration_s: float
) -> tuple[FloatArray, IntArray]:
    """Quantise edges to a step clock: each moves to the first tick at or after it; the last edge of a tick wins.

    Parameters
    ----------
    times_s, index : (E,)
        As returned by `step_edges`.
    tick_s : float
        Period of the clock in s, above 0; one tick is at 0.
    duration_s : float
        Later edges are dropped.

    Examples
    --------
    >>> quantise_to_ticks(np.array([0.33, 0.66, 0.69, 1.0]), np.array([1, 2, 3, 4]), 0.25, 1.0)
    (array([0.5 , 0.75, 1.  ]), array([1, 3, 4]))
    """
    # An edge that is due at a tick must not slip to the next one by rounding.
    ticks = np.ceil(times_s / tick_s * (1.0 - SLACK))
    last = np.append(np.diff(ticks) > 0.0, True)[: ticks.size]
    times = ticks[last] * tick_s
    within = times <= duration_s * (1.0 + SLACK)
    return np.minimum(times[within], duration_s), index[last][within]


def steps_travelled(profile: RateProfile, times_s: FloatArray) -> FloatArray:
    """Return the full steps travelled since t = 0, the sum over both directions, (N,).

    Parameters
    ----------
    profile : RateProfile
        Commanded rate in full steps/s.
    times_s : (N,) float
        Command time in s, N at least 1; the travel is 0 before time 0.

    Raises
    ------
    UsageError
        There are more steps than `MOST_EDGES`.

    Examples
    --------
    >>> sweep = RateProfile.through([(0.0, 2.0), (4.0, -2.0)])
    >>> steps_travelled(sweep, np.array([-1.0, 2.0, 4.0, 5.0]))
    array([0., 2., 4., 6.])
    """
    end_s = float(np.max(times_s))
    if end_s <= 0.0:
        return np.zeros_like(times_s)
    pieces = _pieces(profile, 1, end_s)
    before = np.concatenate([[0.0], running_sum(np.abs(pieces.end - pieces.start))])
    at = np.maximum(np.searchsorted(pieces.start_s, times_s, side="right") - 1, 0)
    # Times before the first piece have travelled nothing.
    lapse = np.clip(times_s - pieces.start_s[at], 0.0, pieces.duration_s[at])
    start, end = np.abs(pieces.start_rate)[at], np.abs(pieces.end_rate)[at]
    done: FloatArray = before[at] + lapse * (start + (end - start) * lapse / (2.0 * pieces.duration_s[at]))
    return done


def _pieces(profile: RateProfile, n: int, duration_s: float) -> Pieces:
    """Cut a profile into pieces, with the positions at their ends."""
    start_s, duration, start_rate, end_rate = _split_at_reversals(*_segments(profile, duration_s))
    # A mistaken rate may overflow to inf or nan: the comparison below is negated so that it refuses both.
    with np.errstate(over="ignore", invalid="ignore"):
        travel = n * duration * (start_rate + end_rate) / 2
        total = float(np.sum(np.abs(travel)))
    if not total <= MOST_EDGES:
        raise UsageError(
            f"{total:.3g} steps in {duration_s} s, more than {MOST_EDGES}; check the rate (full steps/s), "
            "whether the record's time is in ms, and whether its clock is that of a calendar: then write as "
            "time_offset_s the time on it at which the command starts"
        )
    end = running_sum(travel)
    start = np.concatenate([[0.0], end[:-1]])
    return Pieces(start_s, duration, n * start_rate, n * end_rate, start[: end.size], end)


def _segments(profile: RateProfile, duration_s: float) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return start and end times and rates of the linear segments that overlap 0 < t < duration.

    Segments that extend beyond the duration are not cut, so that no edge depends on the duration.
    """
    times, rates = (np.array(column, dtype=np.float64) for column in (profile.times_s, profile.rates))
    times = np.concatenate([[min(0.0, times[0])], times, [max(duration_s, times[-1])]])
    rates = np.concatenate([rates[:1], rates, rates[-1:]])
    used = (times[:-1] < times[1:]) & (times[1:] > 0.0) & (times[:-1] < duration_s)
    start_s, end_s, start_rate, end_rate = (column[used] for column in (times[:-1], times[1:], rates[:-1], rates[1:]))
    # Only the segment across t = 0 is cut; its rate there lies on its line.
    cut = np.maximum(-start_s, 0.0)
    start_rate = start_rate + (end_rate - start_rate) * (cut / (end_s - start_s))
    return np.maximum(start_s, 0.0), end_s, start_rate, end_rate


def _split_at_reversals(
    start_s: FloatArray, end_s: FloatArray, start_rate: FloatArray, end_rate: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return start times, durations, start and end rates, with a cut wherever the rate changes sign."""
    duration = end_s - start_s
    reverses = np.sign(start_rate) * np.sign(end_rate) < 0
    whole = np.ones_like(duration)
    before = np.divide(start_rate, start_rate - end_rate, out=whole, where=reverses) * duration
    after = np.where(reverses, duration - before, 0.0)
    turning_rate = np.where(reverses, 0.0, end_rate)
    halves = (
        (start_s, start_s + before),
        (before, after),
        (start_rate, turning_rate),
        (turning_rate, end_rate),
    )
    starts, durations, first_rates, last_rates = (np.stack(pair, axis=1).ravel() for pair in halves)
    # A segment without a reversal leaves an empty second half.
    kept = durations > 0.0
    return starts[kept], durations[kept], first_rates[kept], last_rates[kept]


def running_sum(terms: FloatArray) -> FloatArray:
    """Return the cumulative sum with compensated rounding errors, (P,).

    The errors are exact (Knuth's two-sum), so that the result is nearly as accurate as the rounded
    exact sums, whatever the number of terms.
    """
    plain: FloatArray = np.cumsum(terms)
    before = np.concatenate([[0.0], plain[:-1]])[: plain.size]
    added = plain - before
    errors: FloatArray = (before - (plain - added)) + (terms - added)
    caught: FloatArray = np.cumsum(errors)
    return plain + caught


def _held_index(pieces: Pieces) -> FloatArray:
    """Return the step index at t = 0 and at the end of each piece, (P + 1,).

    While the position rises, the index is the highest step reached or stays; while it falls, the lowest.
    """
    peak_rate = np.max(np.maximum(np.abs(pieces.start_rate), np.abs(pieces.end_rate)), initial=0.0)
    slack = SLACK * peak_rate * pieces.end_s
    lowest = np.where(pieces.direction > 0, np.floor(pieces.end + slack), -np.inf)
    highest = np.where(pieces.direction < 0, np.ceil(pieces.end - slack), np.inf)
    limits = zip(lowest.tolist(), highest.tolist(), strict=True)
    return np.array(list(accumulate(limits, _clip_to, initial=0.0)))


def _clip_to(index: float, limits: Sequence[float]) -> float:
    """Return the index clipped to the limits."""
    return min(max(index, limits[0]), limits[1])


def _instants(pieces: Pieces, piece: IntArray, index: FloatArray) -> FloatArray:
    """Return the instant at which each index is reached, inside its piece, (E,).

    The time is counted from the start of the piece. Where a decelerating command is past the middle, it is counted
    back from the end: the root from the start would cancel there, and with it the speed at the edge.
    """
    start_speed, end_speed = np.abs(pieces.start_rate)[piece], np.abs(pieces.end_rate)[piece]
    acceleration = (end_speed - start_speed) / pieces.duration_s[piece]
    done = np.maximum((index - pieces.start[piece]) * pieces.direction[piece], 0.0)
    left = np.maximum((pieces.end[piece] - index) * pieces.direction[piece], 0.0)
    backwards = (end_speed < start_speed) & (left < done)
    lapse = time_to_travel(
        np.where(backwards, left, done),
        np.where(backwards, end_speed, start_speed),
        np.where(backwards, -acceleration, acceleration),
    )
    start_s, end_s = pieces.start_s[piece], pieces.end_s[piece]
    return np.clip(np.where(backwards, end_s - lapse, start_s + lapse), start_s, end_s)


def time_to_travel(distance: FloatArray, speed: FloatArray, acceleration: FloatArray) -> FloatArray:
    """Return the first root t of distance = speed t + acceleration t^2 / 2, (E,).

    The form 2 d / (v + sqrt(v^2 + 2 a d)) neither cancels nor divides by the acceleration.
    """
    final_speed = np.sqrt(speed**2 + 2 * acceleration * distance)
    return np.divide(2 * distance, speed + final_speed, out=np.zeros_like(distance), where=distance > 0.0)
