"""Chord method for the optima of draws near the estimate, for many draws at once.

A draw differs from the simulation at the estimate by noise alone, so its optimum is near, and the derivatives there are
nearly those at the estimate. Newton's method with a fixed derivative (the chord method) needs only the estimate's
sensitivities, and simulates the residuals of all draws together. It converges to a zero of the gradient along these
derivatives. A draw for which it does not converge is refitted by the general solver.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.identification.output_error.misfit import Misfit, Window, batch_misfits
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import WeightedRows
from mechid.identification.output_error.target import Target
from mechid.identification.refit.settings import REFIT
from mechid.identification.search.settings import SEARCH

CONVERGED_FALL = 0.1 * SEARCH.negligible_fall
"""Predicted fall of the cost, in sigmas squared, at which a draw has converged. It is smaller than elsewhere, since the
slopes are not exact."""


@dataclass(frozen=True, eq=False)
class Chord:
    """The derivatives at the estimate.

    Attributes
    ----------
    slopes : mapping of str to tuple of (m, n)
        dr/dq of each record's channels over its window, weighted, with offset and drift projected out.
    inverse : (m, m)
        Inverse of J^T J over records and priors, zero for coordinates that do not move.
    """

    slopes: Mapping[str, tuple[FloatArray, ...]]
    inverse: FloatArray


@dataclass(frozen=True)
class DrawOptimum:
    """The optimum of a draw: its point, and the cost there in sigmas squared."""

    q: FloatArray
    cost: float


def chord_at(problem: Problem, q: FloatArray, windows: Windows, moving: BoolArray) -> Chord | None:
    """Return the derivatives of a problem at `q`; None where they need too much memory."""
    used = [t for t in problem.targets if t.name in windows]
    samples = sum((windows[t.name][1] - windows[t.name][0]) * len(t.channels) for t in used)
    if samples * problem.size > REFIT.most_numbers:
        return None
    slopes = {t.name: _slopes(problem, t, q, windows[t.name]) for t in used}
    J = problem.joint(q, windows).jacobian[:, moving]
    inverse = np.zeros((problem.size, problem.size))
    inverse[np.ix_(moving, moving)] = _inverse(J)
    return Chord(slopes, inverse)


def _slopes(problem: Problem, target: Target, q: FloatArray, window: Window) -> tuple[FloatArray, ...]:
    rows = WeightedRows(Misfit(problem.model, target, q, window, jacobian=True))
    n = window[1] - window[0]
    kept = [np.zeros((width, n)) for width in rows.widths]
    done = [0] * len(kept)
    for k, block, count in rows:
        kept[k][:, done[k] : done[k] + count] = block[:, :count]
        done[k] += count
    found = []
    for channel, whole in zip(target.channels, kept, strict=True):
        removed, J = whole[: channel.projected_columns], whole[channel.projected_columns + 1 :]
        if channel.projected_columns:
            J -= np.linalg.lstsq(removed.T, J.T, rcond=None)[0].T @ removed
        found.append(J / channel.scale)
    return tuple(found)


def _inverse(J: FloatArray) -> FloatArray:
    """Return (J^T J)^-1, without the directions that the records do not see."""
    # Scaled to unit columns: the threshold on eigenvalues then does not depend on the coordinates' units.
    scale = np.maximum(np.linalg.norm(J, axis=0), 1e-300)
    values, vectors = np.linalg.eigh((J / scale).T @ (J / scale))
    seen = values > REFIT.weak * values.max(initial=0.0)
    half = vectors[:, seen] / np.sqrt(values[seen]) / scale[:, np.newaxis]
    return np.asarray(half @ half.T)


def chord_optima(
    chord: Chord, draws: Sequence[Problem], start: FloatArray, windows: Windows
) -> list[DrawOptimum | None]:
    """Return the optimum of each draw; None where the chord method does not converge.

    Parameters
    ----------
    chord : Chord
    draws : sequence of Problem
        Problems that differ in their measured samples and in the values of their priors.
    start : (m,)
    windows : mapping of str to (first, stop)
    """
    found: list[DrawOptimum | None] = [None] * len(draws)
    points, left = [start.copy() for _ in draws], list(range(len(draws)))
    for _ in range(REFIT.chord_steps):
        gradients, costs = _gradients_and_costs([draws[k] for k in left], [points[k] for k in left], chord, windows)
        going = []
        for k, gradient, cost in zip(left, gradients, costs, strict=True):
            step = -chord.inverse @ gradient
            if not np.isfinite(cost):
                continue
            if -gradient @ step < CONVERGED_FALL:
                found[k] = DrawOptimum(points[k], cost)
                continue
            points[k] = points[k] + step
            # A step beyond a bound leaves the draw to the general solver, which handles bounds.
            if np.array_equal(points[k], draws[k].coordinates.clip(points[k])):
                going.append(k)
        left = going
        if not left:
            break
    return found


def _gradients_and_costs(
    draws: Sequence[Problem], points: Sequence[FloatArray], chord: Chord, windows: Windows
) -> tuple[list[FloatArray], list[float]]:
    """Return the gradient of each draw at its point along the chord's derivatives, and the cost."""
    gradients, costs = [], []
    for draw, q in zip(draws, points, strict=True):
        away, J = draw.coordinates.prior_rows(q)
        gradients.append(J.T @ away if away.size else np.zeros(q.size))
        costs.append(float(away @ away))
    names = [t.name for t in draws[0].targets]
    for number, name in enumerate(names):
        pairs = [(draw.targets[number], q) for draw, q in zip(draws, points, strict=True)]
        numbers = iter(range(len(pairs)))
        for misfits in batch_misfits(draws[0].model, pairs, windows[name]):
            own = [next(numbers) for _ in misfits]
            for k, gradient, cost in zip(own, *_sums(misfits, chord.slopes[name]), strict=True):
                gradients[k] = gradients[k] + gradient
                costs[k] += cost
    return gradients, costs


def _sums(misfits: Sequence[Misfit], slopes: Sequence[FloatArray]) -> tuple[list[FloatArray], list[float]]:
    """Return J^T r and the sum of squares of each misfit, with offset and drift projected out of the residual."""
    target, window = misfits[0].target, misfits[0].window
    rows = [WeightedRows(misfit) for misfit in misfits]
    whole = [np.zeros((width, window[1] - window[0])) for width in rows[0].widths]
    series = [[np.zeros(window[1] - window[0]) for _ in target.channels] for _ in misfits]
    done = [0] * len(target.channels)
    for parts in zip(*rows, strict=True):
        k, _, n = parts[0]
        here = slice(done[k], done[k] + n)
        whole[k][:, here] = parts[0][1][:, :n]
        for own, (_, block, _) in zip(series, parts, strict=True):
            own[k][here] = block[target.channels[k].projected_columns, :n]
        done[k] += n
    gradients, costs = [], []
    # One by one: a matrix product over many residuals would round differently.
    for misfit, own in zip(misfits, series, strict=True):
        gradient, cost = np.zeros(len(slopes[0])), 0.0 if misfit.is_complete else np.inf
        for k, channel in enumerate(target.channels):
            removed, r = whole[k][: channel.projected_columns], own[k] / channel.scale
            gradient += slopes[k] @ r
            left = r - np.linalg.lstsq(removed.T, r, rcond=None)[0] @ removed if channel.projected_columns else r
            cost += float(left @ left) if np.isfinite(cost) else 0.0
        gradients.append(gradient)
        costs.append(cost)
    return gradients, costs
