"""Gated horizons: a record counts only as far as the present model follows it.

A small parameter error flips one stick/slip event and everything after it is meaningless; a fit
through it drags the weak directions away. So each record is used up to its first divergence from the
present model, and this horizon is found anew after every few steps of the solver. Inside the gates the
cost is smooth, and better parameters move the next fault outward until all records are complete.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from scipy.special import chdtri

from mechid.arrays import FloatArray
from mechid.identification.computation.journal import Journal
from mechid.identification.output_error.identity import identity
from mechid.identification.output_error.misfit import Misfit, Piece
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.search.first_moments import (
    Horizons,
    Lifted,
    grow_from_records_at_rest,
    motion_begins,
    restart_records,
)
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import Solution, solve
from mechid.signal.series import stretch_of
from mechid.signal.stored import Room, room_for
from mechid.signal.trend import Line, fit_line


@dataclass(frozen=True)
class Growth:
    """Where gated growth ended: coordinates, samples of each record followed, and whether all are."""

    q: FloatArray
    horizons: Mapping[str, int]
    complete: bool
    rounds: int

    def reached(self, problem: Problem) -> float:
        """Share of all samples that the model follows."""
        return sum(self.horizons.values()) / sum(t.samples for t in problem.targets)


def least_horizons(problem: Problem) -> Horizons:
    """Return the least horizon of each record, past its burn-in: 15 ms, or one window past the first motion."""
    return {t.name: _floor(t) for t in problem.targets}


def _floor(target: Target) -> int:
    """Return the least horizon by the channel that moves first."""
    rate = target.base.sample_rate_hz
    least, window = max(int(SEARCH.floor_s * rate), 8), max(int(SEARCH.gate_window_s * rate), 4)
    return min(max(target.burn_in + least, motion_begins(target) + window), target.samples)


def horizon(
    problem: Problem, target: Target, q: FloatArray, gate: int, floor: int, *, most: float = SEARCH.diverged_at
) -> int:
    """Return how many samples the model at `q` follows, at most twice the gate unless it is all of them.

    It follows up to the first window whose mean square exceeds `most`, in sigmas squared, in any channel.

    What is projected out is fitted up to the gate and continued: as an offset alone, which tells little of
    a drift, and with the drift, which a misfit within a short gate throws off. The longer one counts.
    """
    window = gate_window(target)
    traces = [_Trace(channel, room_for(target.samples), most) for channel in target.channels]
    tested = 0
    for piece in Misfit(problem.model, target, q, (0, target.samples), block=SEARCH.short_block):
        for k, trace in enumerate(traces):
            trace.take(piece, k)
        if not all(np.isfinite(trace.residual[piece.stop - 1 : piece.stop][0]) for trace in traces):
            break
        if piece.stop < gate and piece.stop < target.samples:
            continue
        if not tested:
            for trace in traces:
                trace.begin(min(gate, piece.stop))
        whole = (piece.stop - tested) // window
        good = min(trace.follows(tested, whole, window) for trace in traces)
        tested += good * window
        if good < whole:
            break
    else:
        return target.samples
    return max(min(tested, 2 * gate), floor)


@dataclass
class _Trace:
    """Residual of a channel on its way, n samples in sigmas, and what may be projected out of it."""

    channel: TargetChannel
    residual: Room
    most: float
    lines: list[Line] = field(default_factory=list)

    def take(self, piece: Piece, k: int) -> None:
        """Add what is left of the channel, which is the k-th, over a piece."""
        self.residual[piece.first : piece.stop] = piece.residual(k) / self.channel.sigma

    def begin(self, samples: int) -> None:
        """Fit what is projected out, without drift and with it where that may be."""
        rejected = self.channel.rejected_within((0, samples))
        terms = range(1, self.channel.linear + 1)
        begun, turns = stretch_of(self.residual, 0, samples), self.channel.turns
        self.lines = [fit_line(begun, n, rejected) for n in terms] or [Line()]
        self.lines += [fit_line(begun, n, rejected, turns) for n in terms or [0]] if turns else []

    def follows(self, first: int, whole: int, window: int) -> int:
        """Return how many windows in a row from `first` on the model follows, of so many; keep what followed all."""
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
        """Mean square that is no chance: rounding alone may stand at 3 of its variances for as long as it likes."""
        return max(self.most, SEARCH.diverged_at * (self.channel.rounding / self.channel.sigma) ** 2)


def followed_samples(problem: Problem, target: Target, q: FloatArray, *, most: float = SEARCH.diverged_at) -> int:
    """Return how many samples the model at `q` follows, whatever comes after."""
    gate = _floor(target)
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
    most: float = SEARCH.diverged_at,
) -> Horizons:
    """Return the horizon of every record at `q`."""
    return {t.name: horizon(problem, t, q, gates[t.name], least[t.name], most=most) for t in problem.targets}


def unfollowed_records(problem: Problem, q: FloatArray, *, most: float = SEARCH.diverged_at) -> list[str]:
    """Return the records that are not followed to their ends at `q`."""
    whole = {t.name: t.samples for t in problem.targets}
    found = horizons_at(problem, q, whole, least_horizons(problem), most=most)
    return [name for name, n in whole.items() if found[name] < n]


def chance_limit(problem: Problem) -> float:
    """Return a mean square that white noise exceeds in one of 1e9 windows, in sigmas squared."""
    return chance_limit_of(min(map(gate_window, problem.targets)))


def chance_limit_of(samples: float) -> float:
    """Return a mean square of so many independent samples that is exceeded once in 1e9 times, in sigmas squared."""
    return float(chdtri(samples, 1e-9)) / samples


def gate_window(target: Target) -> int:
    """Return how many samples a target's windows have, 5 ms of them."""
    return max(int(SEARCH.gate_window_s * target.base.sample_rate_hz), 4)


def grow_horizons(
    problem: Problem,
    q: FloatArray,
    rng: np.random.Generator,
    progress: Callable[[FloatArray, Horizons], None] = lambda q, gates: None,
    *,
    most: float = SEARCH.diverged_at,
    escapes: float = math.inf,
    journal: Journal | None = None,
) -> Growth:
    """Grow all horizons from where `q` follows until all records are complete, or so many escapes do not help."""
    if problem.anchored is not problem:

        def grow_part(part: Problem, at: FloatArray, lifted: Lifted) -> tuple[FloatArray, Horizons]:
            found = grow_horizons(part, at, rng, lambda *moved: progress(*lifted(*moved)), most=most, journal=journal)
            return found.q, dict(found.horizons)

        q = grow_from_records_at_rest(problem, q, least_horizons(problem), grow_part, partial(_some_rounds, most=most))
    done, own = journal or Journal(), [identity(problem), most]
    least, whole = least_horizons(problem), {t.name: t.samples for t in problem.targets}
    gates = done.step("growth begins", [own, q], partial(_followed_at, problem, q, least, most))
    furthest, stalled = 0, 0
    for rounds in range(1, SEARCH.rounds + 1):
        before = gates
        q, gates, settled = done.step("growth round", [own, q, gates], partial(_round, problem, q, gates, least, most))
        progress(q, gates)
        if gates == whole:
            return Growth(q, gates, True, rounds)
        stalled = stalled + 1 if sum(gates.values()) <= furthest else 0
        furthest = max(furthest, sum(gates.values()))
        if stalled >= SEARCH.patience or (settled and gates == before):
            escapes -= 1
            work = partial(_escape, problem, q, gates, least, rng, most)
            escaped = done.step("escape", [own, q, gates], work, rng) if escapes >= 0 else None
            if escaped is None or sum(escaped[1].values()) <= furthest:
                return Growth(q, gates, False, rounds)
            q, gates = escaped
            stalled = 0
    return Growth(q, gates, False, SEARCH.rounds)


def _followed_at(problem: Problem, q: FloatArray, least: Horizons, most: float) -> Horizons:
    return {t.name: max(followed_samples(problem, t, q, most=most), least[t.name]) for t in problem.targets}


def _round(
    problem: Problem, q: FloatArray, gates: Horizons, least: Horizons, most: float
) -> tuple[FloatArray, Horizons, bool]:
    """Return where some steps inside the gates lead, the horizons there, and whether that has settled."""
    step = _some_steps(problem, q, gates)
    settled = step.converged or np.array_equal(step.q, q)
    return step.q, horizons_at(problem, step.q, gates, least, most=most), settled


def _some_steps(problem: Problem, q: FloatArray, gates: Mapping[str, int]) -> Solution:
    return solve(problem, q, {name: (0, n) for name, n in gates.items()}, steps=5, tolerance=1e-6)


def _escape(
    problem: Problem, q: FloatArray, gates: Horizons, least: Horizons, rng: np.random.Generator, most: float
) -> tuple[FloatArray, Horizons] | None:
    """Draw from the present posterior, wider and wider, for a point that follows the records further.

    Draws are simulated on the unfinished records some way past their gates. First those that go past a gate
    by themselves are tried, refitted and as they are; then, while most of the records is still ahead, the one of
    least cost of each width, refitted.
    """
    open_targets = [t for t in problem.targets if gates[t.name] < t.samples]
    begun = _begun_anew(problem, q, open_targets, gates, least, most)
    if begun is not None:
        return begun
    root = _posterior_root(problem, q, gates)
    draws = [
        problem.coordinates.clip(q + scale * rng.standard_normal((SEARCH.escape_draws, problem.size)) @ root.T)
        for scale in SEARCH.escape_widths
    ]

    def longer(moved: FloatArray) -> tuple[FloatArray, Horizons] | None:
        found = horizons_at(problem, moved, gates, least, most=most)
        return (moved, found) if sum(found.values()) > sum(gates.values()) else None

    for some in draws:
        gains = [_gain_beyond(problem, open_targets, gates, draw, most) for draw in some]
        for i in [i for i in np.argsort(gains, kind="stable")[::-1][: SEARCH.escape_winners] if gains[i] > 0]:
            found = longer(_refitted(problem, some[i], gates, least, most)) or longer(some[i])
            if found:
                return found
    if 2 * sum(gates.values()) > sum(t.samples for t in problem.targets):
        return None
    for some in draws:
        costs = [_cost_beyond(problem, open_targets, gates, draw) for draw in some]
        i = int(np.argmin(costs))
        found = longer(_refitted(problem, some[i], gates, least, most)) if math.isfinite(costs[i]) else None
        if found:
            return found
    return None


def _begun_anew(
    problem: Problem, q: FloatArray, targets: list[Target], gates: Horizons, least: Horizons, most: float
) -> tuple[FloatArray, Horizons] | None:
    """Return where other starts of the records that begin in motion and are not followed lead; None where nowhere."""
    moved = restart_records(problem, q, gates, partial(_some_rounds, most=most), targets=targets)
    if moved is q:
        return None
    found = horizons_at(problem, moved, gates, least, most=most)
    return (moved, found) if sum(found.values()) > sum(gates.values()) else None


def _some_rounds(problem: Problem, q: FloatArray, gates: Horizons, *, most: float) -> tuple[FloatArray, Horizons]:
    """Return where some rounds lead as long as the horizons grow, and how far these are then."""
    for _ in range(SEARCH.start_rounds):
        q = _some_steps(problem, q, gates).q
        further = horizons_at(problem, q, gates, gates, most=most)
        if further == gates:
            break
        gates = further
    return q, gates


def _refitted(problem: Problem, q: FloatArray, gates: Horizons, least: Horizons, most: float) -> FloatArray:
    """Return a draw after some steps on as much of the records as it follows, at least up to the gates."""
    own = horizons_at(problem, q, gates, least, most=most)
    return _some_steps(problem, q, {name: max(gates[name], n) for name, n in own.items()}).q


def _gain_beyond(problem: Problem, targets: list[Target], gates: Horizons, q: FloatArray, most: float) -> int:
    """Return how many samples more than the gates the model at `q` follows, 80 ms past them at most."""
    gain = 0
    for target in targets:
        gate, past = gates[target.name], int(SEARCH.beyond_s * target.base.sample_rate_hz)
        gain += min(horizon(problem, target.beginning(gate + past), q, gate, 0, most=most), gate + past) - gate
    return gain


def _posterior_root(problem: Problem, q: FloatArray, gates: Horizons) -> FloatArray:
    """Return a square root of the covariance at `q`, (n, n); what the gates do not show varies over its range."""
    span = problem.coordinates.span
    J = problem.joint(q, {name: (0, n) for name, n in gates.items()}).jacobian * span
    _, s, Vt = np.linalg.svd(np.nan_to_num(J), full_matrices=False)
    return np.asarray(span[:, None] * Vt.T / np.sqrt(s**2 + 1.0), dtype=np.float64)


def _cost_beyond(problem: Problem, targets: list[Target], gates: Horizons, q: FloatArray) -> float:
    total = 0.0
    for target in targets:
        stop = min(gates[target.name] + int(SEARCH.beyond_s * target.base.sample_rate_hz), target.samples)
        norm = problem.norm(target, q, (0, stop))
        total += norm**2 if math.isfinite(norm) else math.inf
    return total
