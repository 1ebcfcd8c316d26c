"""Level of an ensemble estimated from draws, with its sampling standard error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from mechid.arrays import FloatArray
from mechid.budgets.ensemble import Members
from mechid.budgets.indices import Index
from mechid.budgets.levels import Mixture, gaussians, member_level, quantile, share_below, worst_share
from mechid.budgets.settings import LEVEL


@dataclass(frozen=True)
class FromDraws:
    """Value estimated from draws, and its standard error."""

    value: float
    sigma: float


def ensemble_level(
    member: Callable[[FloatArray], Mixture],
    members: Members,
    index: Index,
    confidence: float,
    axis: int | None,
    interpretation: str,
) -> FromDraws:
    """Return the level in rad by a statistical interpretation, at `LEVEL.quick_points` instants of each member.

    Parameters
    ----------
    member : callable
        From a draw (k,) to the member.
    members : Members
        Their draws, (r, n, k).
    index, confidence, axis, interpretation
        As in the requirement.
    """
    if interpretation == "mixed":
        # A mixture of Gaussians needs no ranking of members.
        return _from_draws(*_all_times(member, members, index, axis), confidence)
    ranks = np.array(
        [
            [[member_level(member(draw), index, confidence, axis, interpretation, LEVEL.quick_points)] for draw in of]
            for of in members.draws
        ]
    )
    share = worst_share(confidence) if interpretation == "temporal" else confidence
    return _from_draws(ranks, np.zeros_like(ranks), members.weights[:, :, None], share)


def _all_times(
    member: Callable[[FloatArray], Mixture], members: Members, index: Index, axis: int | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return all times of all members as Gaussians: centres, sigmas and weights, (r, n, q) each."""
    places = np.arange(LEVEL.members) / LEVEL.members + np.arange(len(members.draws))[:, None] / len(members.draws)
    parts = [
        [_few_instants(member(draw), index, axis, place % 1.0) for draw, place in zip(*row, strict=True)]
        for row in zip(members.draws, places, strict=True)
    ]
    centres, sigmas, shares = (np.array([[p[i] for p in row] for row in parts]) for i in range(3))
    return centres, sigmas, members.weights[:, :, None] * shares


def _few_instants(
    member: Mixture, index: Index, axis: int | None, place: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return a member as a subset of the Gaussians of its mixture: centres, sigmas, weights, which add to 1.

    Instants are kept at a fixed stride from each error. The offset of the first instant, a place from 0 to 1, increases
    from member to member, so that offsets and first coordinates of the members fill the unit square evenly (Hammersley
    points); it differs from replica to replica.
    """
    parts = [(w, *gaussians(e, index, axis, LEVEL.quick_points)) for w, e in member if w > 0.0]
    kept = [slice(int(place * (c.size // LEVEL.members)), None, c.size // LEVEL.members) for _, c, _ in parts]
    centres = np.concatenate([c[few] for (_, c, _), few in zip(parts, kept, strict=True)])
    sigmas = np.concatenate([s[few] for (_, _, s), few in zip(parts, kept, strict=True)])
    return centres, sigmas, np.repeat([w / LEVEL.members for w, _, _ in parts], LEVEL.members)


def _from_draws(centres: FloatArray, sigmas: FloatArray, weights: FloatArray, share: float) -> FromDraws:
    """Return a quantile of the mixture of all replicas of members (r, n, q), with its standard error.

    The replicas differ in the share below the quantile. This scatter, plus the weight of one member beyond the quantile
    because evenly placed draws may agree by chance, gives the standard error of the share. Its 95 % limits, mapped
    to the quantile, are those of the quantile (Woodruff, Confidence intervals for medians and other position
    measures, Journal of the American Statistical Association 47(260), 1952); the wider side is used.
    """
    replicas = len(weights)
    flat = centres.ravel(), sigmas.ravel(), weights.ravel() / replicas
    value = quantile(*flat, share)
    below = share_below(value, centres, sigmas)
    scatter = float(np.std(np.sum(weights * below, axis=(1, 2)), ddof=1)) / np.sqrt(replicas)
    one = float(np.sum(weights * (1.0 - below), axis=2).max()) / replicas
    limit = float(stdtrit(replicas - 1, 0.975))
    reach = limit * float(np.hypot(scatter, one))
    # The upper limit stays within half of the remaining tail: a share of 1 has no quantile.
    low, high = max(share - reach, 0.0), min(share + reach, 0.5 * (1.0 + share))
    return FromDraws(value, max(value - quantile(*flat, low), quantile(*flat, high) - value) / limit)
