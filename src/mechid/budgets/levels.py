"""The level that a pointing error stays below with a given confidence, by its own distribution.

ECSS-E-ST-60-10C's summation (`summation`) rests on the central limit theorem and says itself, in A.2.1, that it
is poor where one or two errors dominate, as the lines of a stepper do. Here the distributions are convolved: the
periodic part's own (arcsine, for a single line) with the Gaussian of the random part.

The statistical interpretation (ECSS-E-ST-60-10C, A.1.2) says over what the confidence counts:

- temporal: over time, for the worst member of the ensemble;
- ensemble: over the ensemble, at each member's worst time;
- mixed: over both.

No ensemble with Gaussian sizes has a worst member: the more one draws, the worse. What counts as worst is the member
that a share `worst_share` of them does not exceed, which is mean + n_p sigma of a Gaussian size, as in `summation`.
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


Mixture: TypeAlias = Sequence[tuple[float, PointingError]]
"""The errors of one member by the share of the time in which each is there; the shares add to 1."""


def always(error: PointingError) -> Mixture:
    """Return a member whose error is the same all the time."""
    return ((1.0, error),)


def level(error: PointingError, index: Index, confidence: float, axis: int | None) -> float:
    """Return the level in rad that the error of one member stays below for a share of the time.

    Parameters
    ----------
    error : PointingError
    index : Index
    confidence : float
        Share, between 0 and 1.
    axis : int or None
        Of the line of sight; None takes the half angle of the cone, the root of the squares' sum.
    """
    return mixed_level([always(error)], index, confidence, axis)


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
    """Return the share of the members that are no worse than the one that counts as worst: that of mean + n_p sigma.

    Examples
    --------
    >>> worst_share(0.9973)
    0.99865
    """
    return 0.5 * (1.0 + confidence)


def member_level(
    member: Mixture, index: Index, confidence: float, axis: int | None, interpretation: str, points: int = LEVEL.points
) -> float:
    """Return what one member is ranked by, rad: its level over time, or its error at its worst time.

    Raises
    ------
    UsageError
        The interpretation is unknown.
    """
    if interpretation == "ensemble":
        return max(worst_time(e, index, confidence, axis, points) for w, e in member if w > 0.0)
    if interpretation in INTERPRETATIONS:
        return mixed_level([member], index, confidence, axis, points)
    known = did_you_mean(interpretation, INTERPRETATIONS) or f"; write one of {', '.join(INTERPRETATIONS)}"
    raise UsageError(f'interpretation: unknown "{interpretation}"{known}')


def worst_time(
    error: PointingError, index: Index, confidence: float, axis: int | None, points: int = LEVEL.points
) -> float:
    """Return the error in rad at its worst time.

    The periodic part has a largest value. The random part has none; it counts with the level that it stays below
    with the requirement's confidence.
    """
    largest = ndtri(worst_share(confidence)) * error.sigma(index)
    total = np.abs(error.waveforms(index, points) + error.kept_bias(index)) + largest
    return float(np.sqrt(np.sum(total**2, axis=1)).max() if axis is None else total[:, axis].max())


def gaussians(error: PointingError, index: Index, axis: int | None, points: int) -> tuple[FloatArray, FloatArray]:
    """Return an error as a mixture of Gaussians of equal weight: centres and sigmas, (n,) each."""
    return _cone(error, index, points) if axis is None else _axis(error, index, axis, points)


def _axis(error: PointingError, index: Index, axis: int, points: int) -> tuple[FloatArray, FloatArray]:
    centres = error.waveforms(index, points)[:, axis] + error.kept_bias(index)[axis]
    return centres, np.full(points, error.sigma(index)[axis])


def _cone(error: PointingError, index: Index, points: int) -> tuple[FloatArray, FloatArray]:
    """Return the half angle as centres; the random part is drawn, quasi-randomly, since it is no sum here."""
    sigma, total = error.sigma(index), error.waveforms(index, points) + error.kept_bias(index)
    if np.any(sigma > 0.0):
        total = np.repeat(total, LEVEL.cone_draws, axis=0) + _gaussian(points * LEVEL.cone_draws, sigma.size) * sigma
    angle = np.sqrt(np.sum(total**2, axis=1))
    return angle, np.zeros(angle.size)


@lru_cache(maxsize=8)
def _gaussian(count: int, axes: int) -> FloatArray:
    """Return quasi-random normal draws, (count, axes), the same at each call."""
    draws = qmc.Sobol(axes, seed=0).random(count)
    return np.asarray(ndtri(np.clip(draws, 1e-12, 1.0 - 1e-12)), dtype=np.float64)


def quantile(centres: FloatArray, sigmas: FloatArray, weights: FloatArray, confidence: float) -> float:
    """Return x with P(|e| <= x) = confidence for a mixture of Gaussians, some of no width; weights add to 1."""
    if not np.any(sigmas > 0.0):
        size = np.abs(centres)
        if np.ptp(weights) <= 1e-12 * weights.max():
            return float(np.quantile(size, confidence, method="hazen"))
        order = np.argsort(size)
        reached = np.cumsum(weights[order]) - 0.5 * weights[order]  # Hazen's plotting positions
        return float(np.interp(confidence, reached, size[order]))

    def missing(x: float) -> float:
        return float(weights @ share_below(x, centres, sigmas)) - confidence

    return float(brentq(missing, 0.0, np.abs(centres).max() + 9.0 * sigmas.max(), xtol=1e-7 * sigmas.max()))


def share_below(x: float, centres: FloatArray, sigmas: FloatArray) -> FloatArray:
    """Return P(|e| <= x) of each part of a mixture, some of no width."""
    if not np.any(sigmas > 0.0):
        return np.asarray(np.abs(centres) <= x, dtype=np.float64)
    width = np.maximum(sigmas, 1e-9 * sigmas.max())
    return np.asarray(ndtr((x - centres) / width) - ndtr((-x - centres) / width))
