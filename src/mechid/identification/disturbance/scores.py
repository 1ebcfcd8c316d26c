"""How much of what a fit leaves each disturbance would explain: its score at the optimum, without a fit of its own.

At an optimum the residual has no component along what is free. What a further parameter would take of it follows from
its derivative less what the free ones can imitate (Rao's score test): one pass with sensitivities for all candidates.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.disturbance.disturbance import Disturbance, carried, with_disturbances
from mechid.identification.output_error.misfit import misfit_series
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import combine_triangles
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.signal.moments import norm
from mechid.signal.stored import Room, write_at
from mechid.signal.whiteness import effective_samples

SMALLEST = 1e-300
"""No residual is as small: it stands in for zero in a quotient."""
COLLINEAR = 1e-9
"""Relative size of a direction that others hold already. A choice well above rounding."""


@dataclass(frozen=True)
class Score:
    """What a disturbance would take of the sum of squares, each record's samples counted for what they are worth.

    Attributes
    ----------
    chi_square : float
        By how much the sum would fall, in the noise's variance of a residual that is nothing else.
    dof : int
        How many free numbers that takes.
    share : float
        Of the sum.
    worth : float
        Effective samples of all records.
    """

    chi_square: float
    dof: int
    share: float
    worth: float

    @property
    def over(self) -> float:
        """By how much it exceeds what its degrees of freedom cost by the Bayesian criterion, k ln N."""
        return self.chi_square - self.dof * math.log(max(self.worth, math.e))


def scores(problem: Problem, q: FloatArray, windows: Windows, some: Sequence[Disturbance]) -> dict[str, Score]:
    """Return the score of each disturbance at a point, by its name.

    Each channel counts with its residual's own RMS, and with as many samples as its colour leaves: where the model
    lacks something the noise's level would make anything significant.

    Parameters
    ----------
    problem : Problem
        Without them.
    q : (n,)
        Its optimum.
    windows : mapping of record to (first, stop)
    some : sequence of Disturbance
    """
    judged, worth = by_own_residuals(problem, q, windows)
    wide = with_disturbances(judged, [one for one in some if one.own])
    triangles = wide.triangles(carried(judged, q, wide), windows)
    if not triangles or not all(np.all(np.isfinite(t.jacobian)) for t in triangles):
        return {}
    records, priors = combine_triangles(triangles), judged.prior_triangles(q)
    moved = ~judged.coordinates.on_bound(q)
    residual = np.concatenate([records.fun, *(t.fun for t in priors)])
    free = np.vstack([records.jacobian @ following(judged, q, wide)[:, moved], *(t.jacobian[:, moved] for t in priors)])
    below = np.zeros((residual.size - records.fun.size, wide.size))
    further = np.vstack([records.jacobian, below])
    places, found = {name: j for j, name in enumerate(wide.coordinates.names)}, {}
    for one in some:
        if one.lines_hz:
            found[one.name] = _of_lines(problem, q, windows, one)
            continue
        columns = [places[p.name] for p in one.parameters if p.name in places]
        found[one.name] = score_of(residual, free, further[:, columns], one.dof, worth)
    return found


def score_of(residual: FloatArray, free: FloatArray, further: FloatArray, dof: int, worth: float) -> Score:
    """Return the score of further derivatives, (m, k), beside those of what is free, (m, n), at a residual, (m,)."""
    rest = _least(residual, free)
    fall = max(rest - _least(residual, np.column_stack([free, further])), 0.0)
    left = max(rest - fall, SMALLEST)  # the noise is what is left with it, as in an F test
    return Score(worth * fall / left, dof, fall / max(rest, SMALLEST), worth)


def _of_lines(problem: Problem, q: FloatArray, windows: Windows, one: Disturbance) -> Score:
    """Return the score of lines, against what is left without them: beside strong ones all else is narrow in band.

    All else stays where it is, so that it is a little too low.
    """
    wide, worth = by_own_residuals(with_disturbances(problem, [one]), q, windows)
    levels = {t.name: t.leading.sigma for t in wide.targets}
    before, after = (float(np.sum(np.square(p.with_sigmas(levels).norms(q, windows)))) for p in (_plain(problem), wide))
    return Score(max(before - after, 0.0), one.dof, 1.0 - after / before if before > 0.0 else 0.0, worth)


def _plain(problem: Problem) -> Problem:
    """Return a problem in which nothing is whitened."""
    return replace(problem, targets=tuple(t.each(lambda c: replace(c, prefilter=None)) for t in problem.targets))


def following(plain: Problem, q: FloatArray, wide: Problem) -> FloatArray:
    """Return how the coordinates of a problem with more that is free move with those of the plain one, (m, n).

    Values of single records that the plain one has not follow its mechanism.
    """
    size = plain.space.size
    out = np.zeros((wide.size, plain.size))
    names, slopes = plain.space.value_jacobian(plain.coordinates.of_mechanism(q))
    slope = dict(zip(names, slopes, strict=True))
    rows = {(c.name, c.kind): j for j, c in enumerate(wide.space.coordinates)}
    for i, coordinate in enumerate(plain.space.coordinates):
        out[rows[coordinate.name, coordinate.kind], i] = 1.0
    places = {name: j for j, name in enumerate(plain.coordinates.own_names, size)}
    for j, c in enumerate(wide.coordinates.own, wide.space.size):
        if c.parameter.name in places:
            out[j, places[c.parameter.name]] = 1.0
        elif c.parameter.replaces in slope:
            out[j, :size] = slope[c.parameter.replaces]
    return out


def worth_of(problem: Problem, q: FloatArray, windows: Windows) -> float:
    """Return how many independent samples the residuals at a point are worth, all channels together."""
    return by_own_residuals(problem, q, windows)[1]


def _least(r: FloatArray, J: FloatArray) -> float:
    """Return the least sum of squares of r + J d."""
    size = np.linalg.norm(J, axis=0)
    size[size == 0.0] = 1.0
    step = np.linalg.lstsq(J / size, -r, rcond=COLLINEAR)[0]
    return float(np.sum((r + (J / size) @ step) ** 2))


def by_own_residuals(problem: Problem, q: FloatArray, windows: Windows) -> tuple[Problem, float]:
    """Return the problem with each channel at its residual's level and worth, and what all are worth together."""
    total = 0.0

    def one(target: Target) -> Target:
        nonlocal total
        if target.name not in windows:
            return target
        window = windows[target.name]
        series = misfit_series(problem.model, target, q, window)
        channels = []
        for channel, r in zip(target.channels, series, strict=True):
            changed, worth = _by_own_residual(channel, r, window)
            total += worth
            channels.append(changed)
        return replace(target, channels=tuple(channels))

    return replace(problem, targets=tuple(map(one, problem.targets))), total


def _by_own_residual(channel: TargetChannel, r: Room, window: tuple[int, int]) -> tuple[TargetChannel, float]:
    rejected = channel.rejected_within(window)
    channel.line(r, rejected).take_from(r)
    write_at(r, rejected, 0.0)
    counted = max(r.size - rejected.size, 1)
    rms = norm(r) / math.sqrt(counted)
    worth = effective_samples(r) * counted / r.size if rms > 0.0 else float(counted)
    return replace(channel, prefilter=None, sigma=rms * math.sqrt(counted / worth)), worth
