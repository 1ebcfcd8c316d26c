"""Levels that a pointing error does not exceed with a given confidence, from its own distribution.

The summation of ECSS-E-ST-60-10C (`summation`) rests on the central limit theorem and is, as its A.2.1 states,
inaccurate where one or two errors dominate, as the lines of a stepper do. Here the distributions are convolved: the
periodic part's own (arcsine, for a single line) with the Gaussian of the random part.

The statistical interpretation (ECSS-E-ST-60-10C, A.1.2) defines the population of the confidence:

- temporal: over time, for the worst member of the ensemble;
- ensemble: over the ensemble, at each member's worst time;
- mixed: over both.

An ensemble with Gaussian sizes has no worst member: more draws give a worse one. The member that a share `worst_share`
of them does not exceed is used instead; for a Gaussian size this is mean + n_p sigma, as in `summation`.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri
from scipy.stats import qmc

from mechid.arrays import FloatArray
from mechid.budgets.indices import Index
from mechid.budgets.pointing_error import PointingError
from mechid.budgets.settings import LEVEL
from mechid.errors import UsageError, did_you_mean

INTERPRETATIONS = ("temporal", "ensemble", "mixed")
CONE = "cone"
NEGLIGIBLE_BEYOND = 9.0
"""Standard deviations beyond which a Gaussian has no share in double precision."""

Mixture: TypeAlias = Sequence[tuple[float, PointingError]]
"""Errors of one member with the share of the time for which each applies; the shares add to 1."""


def constant_member(error: PointingError) -> Mixture:
    """Return a member whose error is the same all the time."""
    return ((1.0, error),)


def level(error: PointingError, index: Index, confidence: float, axis: int | None) -> float:
    """Return the level in rad that the error of one member does not exceed for a share of the time.

    Parameters
    ----------
    error : PointingError
    index : Index
    confidence : float
        Share, between 0 and 1.
    axis : int or None
        Position of the line of sight; None takes the half angle of the cone, the root of the sum of squares.
    """
    return mixed_level([constant_member(error)], index, confidence, axis)


def mixed_level(
    members: Sequence[Mixture], index: Index, confidence: float, axis: int | None, points: int = LEVEL.points
) -> float:
    """Return the level in rad for a share of all times of all members."""
    weighted = [(w, e) for member in members for w, e in member if w > 0.0]
    parts = [gaussians(e, index, axis, points) for _, e in weighted]
    centres, sigmas = (np.concatenate(column) for column in zip(*parts, strict=True))
    weights = np.concatenate([np.full(c.size, w / c.size) for (w, _), (c, _) in zip(weighted, parts, strict=True)])
    return quantile(centres, sigmas, weights / weights.sum(), confidence)


def worst_share(confidence: float) -> float:
    """Return the share of the members that do not exceed the reference worst member, mean + n_p sigma.

    Examples
    --------
    >>> worst_share(0.9973)
    0.99865
    """
    return 0.5 * (1.0 + confidence)


def member_level(
    member: Mixture, index: Index, confidence: float, axis: int | None, interpretation: str, points: int = LEVEL.points
) -> float:
    """Return the ranking value of one member, rad: its level over time, or its error at its worst time.

    Raises
    ------
    UsageError
        The interpretation is unknown.
    """
    if interpretation == "ensemble":
        return max(error_at_worst_time(e, index, confidence, axis, points) for w, e in member if w > 0.0)
    if interpretation in INTERPRETATIONS:
        return mixed_level([member], index, confidence, axis, points)
    known = did_you_mean(interpretation, INTERPRETATIONS) or f"; write one of {', '.join(INTERPRETATIONS)}"
    raise UsageError(f'interpretation: unknown "{interpretation}"{known}')


def error_at_worst_time(
    error: PointingError, index: Index, confidence: float, axis: int | None, points: int = LEVEL.points
) -> float:
    """Return the error in rad at its worst time.

    The periodic part has a maximum. The random part has none and enters with the level that it does not exceed at the
    requirement's confidence.
    """
    largest = ndtri(worst_share(confidence)) * error.sigma(index)
    total = np.abs(error.waveforms(index, points) + error.kept_bias(index)) + largest
    return float(np.sqrt(np.einsum("ij,ij->i", total, total).max()) if axis is None else total[:, axis].max())


def gaussians(error: PointingError, index: Index, axis: int | None, points: int) -> tuple[FloatArray, FloatArray]:
    """Return an error as a mixture of equally weighted Gaussians: centres and sigmas, (n,) each."""
    return _cone(error, index, points) if axis is None else _axis(error, index, axis, points)


def _axis(error: PointingError, index: Index, axis: int, points: int) -> tuple[FloatArray, FloatArray]:
    centres = error.waveforms(index, points)[:, axis] + error.kept_bias(index)[axis]
    return centres, np.full(points, error.sigma(index)[axis])


def _cone(error: PointingError, index: Index, points: int) -> tuple[FloatArray, FloatArray]:
    """Return half angles as centres; the random part is drawn quasi-randomly, since a half angle is not a sum."""
    sigma, total = error.sigma(index), error.waveforms(index, points) + error.kept_bias(index)
    count = LEVEL.cone_draws if np.any(sigma > 0.0) else 1
    square = np.zeros((points, count))
    # Axis by axis: NumPy's sum along a last axis of two or three takes many times longer.
    for axis in range(sigma.size):
        along = total[:, axis, None] + (sigma[axis] * _gaussian(points, count, sigma.size)[axis] if count > 1 else 0.0)
        square += along * along
    return np.sqrt(square).ravel(), np.zeros(square.size)


@lru_cache(maxsize=8)
def _gaussian(points: int, count: int, axes: int) -> FloatArray:
    """Return quasi-random normal draws, (axes, points, count), the same at each call."""
    # The same draws at each call, so that differences of two levels do not contain sampling noise.
    draws = qmc.Sobol(axes, seed=0).random(points * count).T.reshape(axes, points, count)
    return np.asarray(ndtri(np.clip(draws, 1e-12, 1.0 - 1e-12)), dtype=np.float64)


def quantile(centres: FloatArray, sigmas: FloatArray, weights: FloatArray, confidence: float) -> float:
    """Return x with P(|e| <= x) = confidence for a mixture of Gaussians, some of zero width; weights add to 1."""
    if not np.any(sigmas > 0.0):
        size = np.abs(centres)
        if np.ptp(weights) <= 1e-12 * weights.max():
            return float(np.quantile(size, confidence, method="hazen"))
        order = np.argsort(size)
        # Hazen's plotting positions, so that weighted and equally weighted draws agree.
        reached = np.cumsum(weights[order]) - 0.5 * weights[order]
        return float(np.interp(confidence, reached, size[order]))

    # Beyond nine sigmas of the widest part the probability is 1 to machine precision. So the root is within them of the
    # centres' own quantile, and parts beyond nine more add all or nothing: mostly a few per cent of them are left.
    size, reach = np.abs(centres), NEGLIGIBLE_BEYOND * sigmas.max()
    below, above = _neighbours(size, weights, confidence)
    low, high = max(below - reach, 0.0), above + reach
    inside, near = size < low - reach, (size >= low - reach) & (size <= high + reach)
    rest = confidence - float(weights[inside].sum())
    weight, centre, width = weights[near], centres[near], _least_widths(sigmas)[near]

    def excess(x: float) -> float:
        return float(weight @ _below(x, centre, width)) - rest

    return float(brentq(excess, low, high, xtol=1e-7 * sigmas.max()))


def _neighbours(size: FloatArray, weights: FloatArray, confidence: float) -> tuple[float, float]:
    """Return the sizes next below and above the weighted quantile; 0 where none is below."""
    if np.ptp(weights) <= 1e-12 * weights.max():
        # Of equal weights two order statistics suffice, for which no sort is needed.
        at = int(np.searchsorted(np.arange(1, size.size + 1) / size.size, confidence))
        after = min(at + 1, size.size - 1)
        parted = np.partition(size, [max(at - 1, 0), after])
        return float(parted[at - 1]) if at > 0 else 0.0, float(parted[after])
    order = np.argsort(size)
    at = int(np.searchsorted(np.cumsum(weights[order]), confidence))
    return float(size[order[at - 1]]) if at > 0 else 0.0, float(size[order[min(at + 1, size.size - 1)]])


def share_below(x: float, centres: FloatArray, sigmas: FloatArray) -> FloatArray:
    """Return P(|e| <= x) of each part of a mixture, some of zero width."""
    if not np.any(sigmas > 0.0):
        return np.asarray(np.abs(centres) <= x, dtype=np.float64)
    return _below(x, centres, _least_widths(sigmas))


def _below(x: float, centres: FloatArray, width: FloatArray) -> FloatArray:
    """Return P(|e| <= x) of Gaussians."""
    return np.asarray(ndtr((x - centres) / width) - ndtr((-x - centres) / width))


def _least_widths(sigmas: FloatArray) -> FloatArray:
    """Return widths: a part of zero width becomes a very narrow Gaussian, so that the sum stays continuous."""
    return np.asarray(np.maximum(sigmas, 1e-9 * sigmas.max()))
