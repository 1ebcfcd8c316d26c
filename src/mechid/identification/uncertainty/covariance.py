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

from mechid.identification.output_error.misfit import Misfit, misfit_series
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduced import reduced
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.output_error.weighted_rows import WeightedRows
from mechid.identification.search.solve import covariance
from mechid.identification.uncertainty.visits import Visits
from mechid.signal.autoregression import Autoregression, fit_autoregression
from mechid.signal.series import blocks
from mechid.signal.trend import fit_line

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Uncertainty:
    """Covariances in search coordinates, (n, n), and the residual model of each record's channels."""

    white: FloatArray
    robust: FloatArray
    colour: dict[str, tuple[Autoregression, ...]]


def uncertainty(
    problem: Problem, q: FloatArray, windows: Windows, triangle: Triangle, seen: NDArray[np.bool_]
) -> Uncertainty:
    """Return both covariances at `q`; coordinates that are not `seen` get zeros.

    Sigmas of the targets are taken as they are: the caller has released them to the residuals. The channels of a
    record are taken as independent of one another.
    """
    used = [t for t in problem.targets if t.name in windows]
    inverse = np.zeros((problem.size, problem.size))
    inverse[np.ix_(seen, seen)] = covariance(Triangle(triangle.norm, triangle.jacobian[:, seen], triangle.samples))
    colour = {t.name: _colours(problem, t, q, windows[t.name]) for t in used}
    _, known = problem.coordinates.prior_rows(q)
    score = known.T @ known
    for t in used:
        score += _score_variance(problem, t, q, windows[t.name], colour[t.name])
    return Uncertainty(inverse, inverse @ score @ inverse, colour)


def residual(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> tuple[FloatArray, ...]:
    """Return the misfit of each channel less offset and drift, (n,) over a window; 0 at rejected samples."""
    series = misfit_series(problem.model, target, q, window)
    for channel, r in zip(target.channels, series, strict=True):
        rejected = channel.rejected_within(window)
        fit_line(r, channel.linear, rejected).take_from(r)
        r[rejected] = 0.0
    return series


def _colours(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> tuple[Autoregression, ...]:
    """Return the model of what stands behind each channel's prefilter."""
    series = _whitened(problem, target, q, window)
    return tuple(
        fit_autoregression(r, rejected=channel.rejected_within(window))
        for channel, r in zip(target.channels, series, strict=True)
    )


def _whitened(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> list[FloatArray]:
    """Return the residuals behind the channels' prefilters, (n,); 0 where their memory is not of the residual."""
    series = residual(problem, target, q, window)
    return [_white(channel, r, window) for channel, r in zip(target.channels, series, strict=True)]


def _white(channel: TargetChannel, r: FloatArray, window: tuple[int, int]) -> FloatArray:
    """Return a residual behind its channel's prefilter, written over it."""
    if channel.prefilter is None:
        return r
    order = channel.order
    memory = np.zeros(order)
    for part in blocks(r.size):
        r[part], memory = lfilter(channel.prefilter.coefficients, [1.0], r[part], zi=memory)
    r[:order] = 0.0
    spoilt = channel.rejected_within((window[0] - order, window[1])) - order
    spoilt = (spoilt[:, np.newaxis] + np.arange(order + 1)).ravel()
    r[spoilt[(spoilt >= 0) & (spoilt < r.size)]] = 0.0
    return r


def _score_variance(
    problem: Problem, target: Target, q: FloatArray, window: tuple[int, int], colour: tuple[Autoregression, ...]
) -> FloatArray:
    """Return J^T C J / sigma^4, summed over channels, with C the residual's covariance.

    Coloured noise: by filtering J through 1/A. Rounding: its error stands still while the channel does, so it is one
    for all samples of a visit to a step of the instrument, of variance q^2/12, and independent between visits.
    """
    triangles, _ = reduced(problem.model, target, q, window, jacobian=True)
    if not any(own.order or c.rounded for own, c in zip(colour, target.channels, strict=True)):
        return sum(map(_white_score, triangles, target.channels, colour), np.zeros((problem.size, problem.size)))
    projections = [_projection(R, c.linear) for R, c in zip(triangles, target.channels, strict=True)]
    memories = [np.zeros((own.order, problem.size)) for own in colour]
    totals = np.zeros((len(colour), problem.size, problem.size))
    visits = [Visits(c.measured[slice(*window)], problem.size) if c.rounded else None for c in target.channels]
    for k, rows, n in WeightedRows(Misfit(problem.model, target, q, window, jacobian=True)):
        linear, scale = target.channels[k].linear, target.channels[k].scale
        J = rows[linear + 1 :, :n].T / scale - rows[:linear, :n].T @ projections[k]
        if (seen := visits[k]) is not None:
            seen.add(J)
        if colour[k].order:
            J, memories[k] = lfilter([1.0], colour[k].coefficients, J, axis=0, zi=memories[k])
        totals[k] += J.T @ J
    score = np.zeros((problem.size, problem.size))
    for channel, total, own, steps in zip(target.channels, totals, colour, visits, strict=True):
        score += total * (1.0 - channel.rounded) * (own.sigma / channel.scale) ** 2
        score += steps.total * channel.rounded if steps else 0.0
    return score


def _white_score(R: FloatArray, channel: TargetChannel, own: Autoregression) -> FloatArray:
    """Return what `_score_variance` is for a white channel: the triangle holds all of it."""
    J = R[channel.linear :, channel.linear + 1 :]
    return np.asarray(J.T @ J * (own.sigma / channel.scale) ** 2, dtype=np.float64)


def _projection(R: FloatArray, linear: int) -> FloatArray:
    """Return what is projected out of the Jacobian, (linear, n)."""
    if not linear:
        return np.zeros((0, 1))
    return np.asarray(np.linalg.solve(R[:linear, :linear], R[:linear, linear + 1 :]), dtype=np.float64)
