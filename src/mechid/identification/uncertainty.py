"""Covariance of the estimate: for white residuals, and robust to their colour.

White: sigma^2 (J^T J)^-1. Robust: (J^T W J)^-1 S (J^T W J)^-1 with S the variance that the score has under
the residual's own autocovariance (Maine and Iliff 1981; Grauer and Morelli 2016). The autocovariance
comes from an autoregressive model of each record's residual, S from a second streamed pass in which the
Jacobian runs through that model: memory does not grow with the record. Where a prefilter whitens a record, all of
this is of what stands behind it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from mechid.identification.problem import Problem, Target, Windows
from mechid.identification.reduction import Triangle
from mechid.identification.solve import covariance
from mechid.identification.weighted_rows import WeightedRows
from mechid.signal.autoregression import Autoregression, fit_autoregression
from mechid.signal.trend import fit_line

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Uncertainty:
    """Covariances in search coordinates, (n, n), and the residual model of each record."""

    white: FloatArray
    robust: FloatArray
    colour: dict[str, Autoregression]


def uncertainty(
    problem: Problem, q: FloatArray, windows: Windows, triangle: Triangle, seen: NDArray[np.bool_]
) -> Uncertainty:
    """Return both covariances at `q`; coordinates that are not `seen` get zeros.

    Sigmas of the targets are taken as they are: the caller has released them to the residuals.
    """
    used = [t for t in problem.targets if t.name in windows]
    inverse = np.zeros((problem.size, problem.size))
    inverse[np.ix_(seen, seen)] = covariance(Triangle(triangle.norm, triangle.jacobian[:, seen], triangle.samples))
    colour = {t.name: fit_autoregression(_whitened(problem, t, q, windows[t.name])) for t in used}
    _, known = problem.prior_rows(q)
    score = known.T @ known
    for t in used:
        score += _score_variance(problem, t, q, windows[t.name], colour[t.name])
    return Uncertainty(inverse, inverse @ score @ inverse, colour)


def residual(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> FloatArray:
    """Return measured minus model minus offset and drift over a window, (n,) N m; 0 at rejected samples."""
    r = problem.misfit(target, q, window)
    fit_line(r, target.linear).take_from(r)
    rejected = target.rejected - window[0]
    r[rejected[(rejected >= 0) & (rejected < r.size)]] = 0.0
    return r


def _whitened(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> FloatArray:
    """Return the residual behind the target's prefilter, (n,) N m; 0 where its memory is not of the residual."""
    r = residual(problem, target, q, window)
    if target.prefilter is None:
        return r
    order = target.prefilter.order
    white = np.asarray(lfilter(target.prefilter.coefficients, [1.0], r), dtype=np.float64)
    white[:order] = 0.0
    for k in (target.rejected - window[0]).tolist():
        white[max(k, 0) : max(k + order + 1, 0)] = 0.0
    return white


def _score_variance(
    problem: Problem, target: Target, q: FloatArray, window: tuple[int, int], colour: Autoregression
) -> FloatArray:
    """Return J^T C J / sigma^4 with C the residual's covariance, by filtering J through 1/A."""
    linear = target.linear
    R, _ = problem.reduced(target, q, window, jacobian=True)
    projection = np.linalg.solve(R[:linear, :linear], R[:linear, linear + 1 :]) if linear else np.zeros((0, 1))
    memory = np.zeros((colour.order, problem.size))
    total = np.zeros((problem.size, problem.size))
    for rows, n in WeightedRows(problem, target, q, window, jacobian=True):
        J = rows[linear + 1 :, :n].T / target.scale - rows[:linear, :n].T @ projection
        if colour.order:
            J, memory = lfilter([1.0], colour.coefficients, J, axis=0, zi=memory)
        total += J.T @ J
    return total * (colour.sigma / target.scale) ** 2
