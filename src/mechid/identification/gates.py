"""Gated horizons: a record counts only as far as the present model follows it.

A small parameter error flips one stick/slip event and everything after it is meaningless; a fit
through it drags the weak directions away. So each record is used up to its first divergence from the
present model, and this horizon is found anew after every few steps of the solver. Inside the gates the
cost is smooth, and better parameters move the next fault outward until all records are complete.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechid.identification.problem import Problem, Target
from mechid.identification.solve import covariance, solve

FloatArray = NDArray[np.float64]
Horizons = dict[str, int]

FLOOR_S = 0.015
WINDOW_S = 0.005
DIVERGED_AT = 4.0
BEYOND_S = 0.08
ROUNDS = 80
PATIENCE = 4
"""Rounds without a new furthest reach after which something else is tried."""


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


def floors(problem: Problem) -> Horizons:
    """Return the least horizon of each record: 15 ms, or one window past the first motion."""
    return {t.name: _floor(t) for t in problem.targets}


def _floor(target: Target) -> int:
    rate = target.base.sample_rate_hz
    least, window = max(int(FLOOR_S * rate), 8), max(int(WINDOW_S * rate), 4)
    quiet = target.measured - np.median(target.measured[:least])
    moving = np.flatnonzero(np.abs(quiet) > 8.0 * target.sigma)
    first = int(moving[0]) + window if moving.size else target.samples
    return min(max(least, first), target.samples)


def horizon(problem: Problem, target: Target, q: FloatArray, gate: int, floor: int) -> int:
    """Return how many samples the model at `q` follows, at most twice the gate unless it is all of them."""
    rate = target.base.sample_rate_hz
    window = max(int(WINDOW_S * rate), 4)
    residual = np.empty(target.samples)
    fitted: FloatArray | None = None
    tested = 0
    for block in problem.run(target, q, target.samples).blocks():
        rows = slice(block.start, block.stop)
        residual[rows] = (block.y[:, 0] - target.measured[rows]) / target.sigma
        if not np.isfinite(residual[block.stop - 1]):
            break
        if block.stop < gate and block.stop < target.samples:
            continue
        if fitted is None:
            fitted = _linear_part(residual[: min(gate, block.stop)], target)
        whole = (block.stop - tested) // window
        stretch = residual[tested : tested + whole * window] - _linear_values(fitted, tested, whole * window)
        bad = np.flatnonzero(np.mean(stretch.reshape(whole, window) ** 2, axis=1) > DIVERGED_AT)
        if bad.size:
            tested += int(bad[0]) * window
            break
        tested += whole * window
    else:
        return target.samples
    return max(min(tested, 2 * gate), floor)


def _linear_part(residual: FloatArray, target: Target) -> FloatArray:
    """Fit what is projected out on the gated part; a drift only where the gate is long enough to tell it."""
    terms = target.linear if residual.size > target.samples // 4 else min(target.linear, 1)
    if terms == 0:
        return np.zeros(1)
    return np.polynomial.polynomial.polyfit(np.arange(residual.size, dtype=float), residual, terms - 1)


def _linear_values(fitted: FloatArray, first: int, count: int) -> FloatArray:
    values = np.polynomial.polynomial.polyval(np.arange(first, first + count, dtype=float), fitted)
    return np.asarray(values, dtype=np.float64)


def horizons_at(problem: Problem, q: FloatArray, gates: Mapping[str, int], least: Mapping[str, int]) -> Horizons:
    """Return the horizon of every record at `q`."""
    return {t.name: horizon(problem, t, q, gates[t.name], least[t.name]) for t in problem.targets}


def grow(
    problem: Problem,
    q: FloatArray,
    rng: np.random.Generator,
    progress: Callable[[Mapping[str, int]], None] = lambda gates: None,
) -> Growth:
    """Grow all horizons from the floor until every record is complete, or nothing helps any more."""
    least = floors(problem)
    gates, whole = dict(least), {t.name: t.samples for t in problem.targets}
    furthest, stalled = 0, 0
    for rounds in range(1, ROUNDS + 1):
        q = _some_steps(problem, q, gates)
        gates = horizons_at(problem, q, gates, least)
        progress(gates)
        if gates == whole:
            return Growth(q, gates, True, rounds)
        stalled = stalled + 1 if sum(gates.values()) <= furthest else 0
        furthest = max(furthest, sum(gates.values()))
        if stalled >= PATIENCE:
            escaped = _escape(problem, q, gates, least, rng)
            if escaped is None or sum(escaped[1].values()) <= furthest:
                return Growth(q, gates, False, rounds)
            q, gates = escaped
            stalled = 0
    return Growth(q, gates, False, ROUNDS)


def _some_steps(problem: Problem, q: FloatArray, gates: Mapping[str, int]) -> FloatArray:
    return solve(problem, q, {name: (0, n) for name, n in gates.items()}, steps=5, tolerance=1e-6).q


def _escape(
    problem: Problem, q: FloatArray, gates: Horizons, least: Horizons, rng: np.random.Generator
) -> tuple[FloatArray, Horizons] | None:
    """Draw from the present posterior, wider and wider, for a point that follows the records further.

    Draws are costed on the unfinished records some way past their gates; the best few are refitted and
    the first that lengthens the total is kept.
    """
    windows = {name: (0, n) for name, n in gates.items()}
    root = np.linalg.cholesky(_regular(covariance(problem.joint(q, windows))))
    open_targets = [t for t in problem.targets if gates[t.name] < t.samples]
    for scale in (1.0, 2.0, 4.0, 8.0, 16.0):
        draws = [
            np.clip(q + scale * root @ rng.standard_normal(problem.size), problem.lower, problem.upper)
            for _ in range(24)
        ]
        costs = [_cost_beyond(problem, open_targets, gates, draw) for draw in draws]
        for i in np.argsort(costs)[:3]:
            moved = _some_steps(problem, draws[i], gates)
            found = horizons_at(problem, moved, gates, least)
            if sum(found.values()) > sum(gates.values()):
                return moved, found
    return None


def _regular(matrix: FloatArray) -> FloatArray:
    """Return a covariance that a Cholesky factor exists of."""
    bump = 1e-12 * np.diag(matrix).max()
    return np.asarray(0.5 * (matrix + matrix.T) + bump * np.eye(len(matrix)), dtype=np.float64)


def _cost_beyond(problem: Problem, targets: list[Target], gates: Horizons, q: FloatArray) -> float:
    total = 0.0
    for target in targets:
        stop = min(gates[target.name] + int(BEYOND_S * target.base.sample_rate_hz), target.samples)
        norm = problem.norm(target, q, (0, stop))
        total += norm**2 if math.isfinite(norm) else math.inf
    return total
