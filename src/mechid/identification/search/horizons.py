"""Horizons of records: the number of samples that the present model follows before it first diverges.

A small parameter error flips one stick-slip event, and everything after it is meaningless. A record is therefore used
only up to its first divergence from the present model: its horizon.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.special import chdtri

from mechid.arrays import FloatArray
from mechid.identification.output_error.misfit import Misfit, Piece
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.search.first_moments import Horizons
from mechid.identification.search.rest import motion_start
from mechid.identification.search.settings import SEARCH
from mechid.signal.series import stretch_of
from mechid.signal.stored_series import WritableSeries, allocate_series
from mechid.signal.trend import Line, fit_line


def least_horizons(problem: Problem) -> Horizons:
    """Return the least horizon of each record past its burn-in: 15 ms, or one window past the first motion."""
    return {t.name: _floor(t) for t in problem.targets}


def _floor(target: Target) -> int:
    """Return the least horizon, given by the channel that moves first."""
    rate = target.base.sample_rate_hz
    least, window = max(int(SEARCH.floor_s * rate), 8), max(int(SEARCH.gate_window_s * rate), 4)
    return min(max(target.burn_in + least, motion_start(target) + window), target.samples)


def horizon(
    problem: Problem, target: Target, q: FloatArray, gate: int, floor: int, *, most: float = SEARCH.gate_limit
) -> int:
    """Return the number of samples that the model at `q` follows, at most twice the gate unless it is the whole record.

    The model follows a record up to the first window whose mean square residual exceeds `most`, in sigmas squared, in
    any channel.

    Offset and drift are fitted up to the gate and extrapolated in two ways: the offset alone, which misses a drift, and
    the offset with the drift, which a misfit within a short gate distorts. The longer of the two horizons counts.
    """
    window = gate_window(target)
    traces = [_Trace(channel, allocate_series(target.samples), most) for channel in target.channels]
    tested = 0
    for piece in Misfit(problem.model, target, q, (0, target.samples), block=SEARCH.short_block):
        for k, trace in enumerate(traces):
            trace.append(piece, k)
        if not all(np.isfinite(trace.residual[piece.stop - 1 : piece.stop][0]) for trace in traces):
            break
        # Offset and drift are fitted up to the gate, so no window is judged before the simulation has reached it.
        if piece.stop < gate and piece.stop < target.samples:
            continue
        if not tested:
            for trace in traces:
                trace.fit_lines(min(gate, piece.stop))
        whole = (piece.stop - tested) // window
        good = min(trace.followed_windows(tested, whole, window) for trace in traces)
        tested += good * window
        if good < whole:
            break
    else:
        return target.samples
    return max(min(tested, 2 * gate), floor)


@dataclass
class _Trace:
    """Growing residual of a channel, n samples in sigmas, and the lines that may be projected out of it."""

    channel: TargetChannel
    residual: WritableSeries
    most: float
    lines: list[Line] = field(default_factory=list)

    def append(self, piece: Piece, k: int) -> None:
        """Append the residual of the k-th channel over a piece."""
        self.residual[piece.first : piece.stop] = piece.residual(k) / self.channel.sigma

    def fit_lines(self, samples: int) -> None:
        """Fit the lines to project out: without drift, with drift if allowed, and with any hum of the channel."""
        rejected = self.channel.rejected_within((0, samples))
        terms = range(1, self.channel.linear + 1)
        initial, turns = stretch_of(self.residual, 0, samples), self.channel.turns
        self.lines = [fit_line(initial, n, rejected) for n in terms] or [Line()]
        self.lines += [fit_line(initial, n, rejected, turns) for n in terms or [0]] if turns else []

    def followed_windows(self, first: int, whole: int, window: int) -> int:
        """Return the number of consecutive followed windows from `first`, at most `whole`.

        Only lines that follow all of these windows are kept.
        """
        good = [self._good_windows(line, first, whole * window, window) for line in self.lines]
        self.lines = [line for line, count in zip(self.lines, good, strict=True) if count == whole]
        return max(good)

    def _good_windows(self, line: Line, first: int, samples: int, window: int) -> int:
        step = max(SEARCH.block // window, 1) * window
        for start in range(first, first + samples, step):
            stop = min(start + step, first + samples)
            off = self.residual[start:stop] - line.at(start, stop)
            off[self.channel.rejected_within((start, stop))] = 0.0
            bad = np.flatnonzero(np.mean(off.reshape(-1, window) ** 2, axis=1) > self._limit)
            if bad.size:
                return (start - first) // window + int(bad[0])
        return samples // window

    @property
    def _limit(self) -> float:
        """Mean square beyond chance."""
        # Rounding errors alone may stay at 3 times their variance for any length of time.
        return max(self.most, SEARCH.gate_limit * (self.channel.rounding / self.channel.sigma) ** 2)


def followed_samples(problem: Problem, target: Target, q: FloatArray, *, most: float = SEARCH.gate_limit) -> int:
    """Return the number of samples that the model at `q` follows from the record's start."""
    gate = _floor(target)
    # `horizon` at most doubles the gate. It is repeated because a longer gate determines offset and drift better.
    while True:
        found = horizon(problem, target, q, gate, 0, most=most)
        if found <= gate or found == target.samples:
            return found
        gate = found


def horizons_at(
    problem: Problem,
    q: FloatArray,
    gates: Mapping[str, int],
    least: Mapping[str, int],
    *,
    most: float = SEARCH.gate_limit,
) -> Horizons:
    """Return the horizon of every record at `q`."""
    return {t.name: horizon(problem, t, q, gates[t.name], least[t.name], most=most) for t in problem.targets}


def unfollowed_records(problem: Problem, q: FloatArray, *, most: float = SEARCH.gate_limit) -> list[str]:
    """Return the names of the records that are not followed to their ends at `q`."""
    whole = {t.name: t.samples for t in problem.targets}
    found = horizons_at(problem, q, whole, least_horizons(problem), most=most)
    return [name for name, n in whole.items() if found[name] < n]


def chance_limit(problem: Problem) -> float:
    """Return the mean square that white noise exceeds in one of 1e9 windows, in sigmas squared."""
    return chance_limit_of(min(map(gate_window, problem.targets)))


def chance_limit_of(samples: float) -> float:
    """Return the mean square of `samples` independent samples that is exceeded once in 1e9 times, in sigmas squared."""
    return float(chdtri(samples, 1e-9)) / samples


def gate_window(target: Target) -> int:
    """Return the number of samples in a target's windows of 5 ms."""
    return max(int(SEARCH.gate_window_s * target.base.sample_rate_hz), 4)
