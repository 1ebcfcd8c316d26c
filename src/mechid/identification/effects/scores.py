"""Score test of effects: how much each would explain of what a model leaves, without a fit of its own.

At an optimum the residual has no component along what is free. What a further effect would take of it follows from
its derivative less what the free ones can imitate (Rao's score test): one pass with sensitivities for all effects.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.effects.disturbance import Disturbance, with_disturbances
from mechid.identification.output_error.misfit import misfit_series
from mechid.identification.output_error.problem import Problem, Windows, transfer_coordinates
from mechid.identification.output_error.reduction import combine_triangles
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.signal.moments import norm
from mechid.signal.stored import WritableSeries, write_at
from mechid.signal.whiteness import effective_samples

SMALLEST = 1e-300
"""No residual is as small: it stands in for zero in a quotient."""
COLLINEAR = 1e-9
"""Relative size of a direction that others hold already. A choice well above rounding."""

Widened = Callable[[Problem, Sequence[str]], tuple[Problem, FloatArray]]
"""From a problem to the one with some effects free, and the model's point there, at which none of them acts."""


def bayesian_penalty(effective_samples: float) -> float:
    """Return what a degree of freedom costs by the Bayesian criterion, ln N (Schwarz 1978)."""
    return math.log(max(effective_samples, math.e))


@dataclass(frozen=True)
class Score:
    """Reduction of the sum of squares by an effect, each record counted by its effective samples.

    Attributes
    ----------
    chi_square : float
        By how much the sum would fall, in the noise's variance of a residual that is nothing else.
    dof : int
        Degrees of freedom that takes.
    share : float
        Of the sum.
    effective_samples : float
        Of all records.
    """

    chi_square: float
    dof: int
    share: float
    effective_samples: float

    @property
    def excess(self) -> float:
        """By how much it exceeds what its degrees of freedom cost by the Bayesian criterion, k ln N."""
        return self.chi_square - self.dof * bayesian_penalty(self.effective_samples)


@dataclass(frozen=True, eq=False)
class Landscape:
    """Derivatives at a model's optimum to what is free, and to effects that it has not.

    Attributes
    ----------
    residual : (m,)
    free : (m, n)
        Derivatives to what is free.
    effects : mapping of str to (m, k)
        Derivatives to each effect.
    effective_samples : float
        Of all records.
    failed : tuple of str
        Effects of which there are no derivatives: the simulation with them fails.
    """

    residual: FloatArray
    free: FloatArray
    effects: Mapping[str, FloatArray]
    effective_samples: float
    failed: tuple[str, ...] = ()

    @property
    def too_wide(self) -> tuple[str, ...]:
        """Effects with which as much would be free as there are effective samples: a fit explains anything then."""
        free = self.free.shape[1]
        return tuple(name for name, J in self.effects.items() if free + J.shape[1] >= self.effective_samples)

    def score(self, *names: str) -> Score:
        """Return what some effects together would take."""
        further = np.column_stack([self.effects[name] for name in names])
        rest = _least(self.residual, self.free)
        fall = max(rest - _least(self.residual, np.column_stack([self.free, further])), 0.0)
        left = max(rest - fall, SMALLEST)  # the noise is what is left with it, as in an F test
        return Score(
            self.effective_samples * fall / left, further.shape[1], fall / max(rest, SMALLEST), self.effective_samples
        )

    def scores(self) -> dict[str, Score]:
        """Return what each effect by itself would take."""
        return {name: self.score(name) for name in self.effects if name not in self.too_wide}

    def like(self, name: str) -> Iterator[str]:
        """Yield the effects that take as much as one does, and with it no more: which of them it is remains open."""
        own = self.score(name)
        for other in self.effects:
            if other != name:
                both, alone = self.score(name, other), self.score(other)
                if both.excess < own.excess and both.excess < alone.excess:
                    yield other


def landscape_at(
    problem: Problem, q: FloatArray, windows: Windows, effects: Mapping[str, Collection[str]], widened: Widened
) -> Landscape:
    """Return the landscape of a problem at its optimum.

    Each channel counts with its residual's own RMS and effective samples: where the model lacks something the noise
    level would make anything significant.

    Parameters
    ----------
    problem : Problem
        Without the effects.
    q : (n,)
        Its optimum.
    windows : mapping of record to (first, stop)
    effects : mapping of str to collection of str
        Dotted names of the coordinates of each effect, by its name.
    widened : callable
    """
    plain, samples = by_own_residuals(problem, q, windows)

    def derivatives(some: Sequence[str]) -> tuple[FloatArray, FloatArray, dict[str, FloatArray]] | None:
        return _derivatives(plain, q, windows, {name: effects[name] for name in some}, widened)

    found, failed = derivatives([*effects]), list[str]()
    if found is None:
        failed = [name for name in effects if not derivatives([name])]
        found = derivatives([name for name in effects if name not in failed])
    if found is None:
        return Landscape(np.zeros(0), np.zeros((0, 0)), {}, samples, tuple(effects))
    return Landscape(*found, samples, tuple(failed))


def _derivatives(
    plain: Problem, q: FloatArray, windows: Windows, effects: Mapping[str, Collection[str]], widened: Widened
) -> tuple[FloatArray, FloatArray, dict[str, FloatArray]] | None:
    """Return the residual and its derivatives to what is free and to some effects; None where the simulation fails."""
    wide, there = widened(plain, [*effects])
    triangles = wide.triangles(there, windows)
    if not triangles or not all(np.all(np.isfinite(t.jacobian)) for t in triangles):
        return None
    records, priors = combine_triangles(triangles), plain.prior_triangles(q)
    moved = ~plain.coordinates.on_bound(q)
    residuals = np.concatenate([records.fun, *(t.fun for t in priors)])
    follows = _followed_coordinates(plain, q, wide)[:, moved]
    free = np.vstack([records.jacobian @ follows, *(t.jacobian[:, moved] for t in priors)])
    further = np.vstack([records.jacobian, np.zeros((residuals.size - records.fun.size, wide.size))])
    columns = {
        name: [j for j, coordinate in enumerate(wide.coordinates.names) if coordinate in own]
        for name, own in effects.items()
    }
    return residuals, free, {name: further[:, places] for name, places in columns.items() if places}


def scores(problem: Problem, q: FloatArray, windows: Windows, some: Sequence[Disturbance]) -> dict[str, Score]:
    """Return the score of each disturbance at the optimum of a problem without them, by its name."""
    own = {one.name: one for one in some if one.own}

    def widened(plain: Problem, names: Sequence[str]) -> tuple[Problem, FloatArray]:
        wide = with_disturbances(plain, [own[name] for name in names])
        return wide, transfer_coordinates(plain, q, wide)

    names = {name: [p.name for p in one.parameters] for name, one in own.items()}
    found = landscape_at(problem, q, windows, names, widened).scores() if own else {}
    found |= {one.name: _of_lines(problem, q, windows, one) for one in some if one.lines_hz}
    return {one.name: replace(found[one.name], dof=one.dof) for one in some if one.name in found}


def _of_lines(problem: Problem, q: FloatArray, windows: Windows, one: Disturbance) -> Score:
    """Return the score of lines, against what is left without them: beside strong ones all else is narrow in band.

    All else stays where it is, so that it is a little too low.
    """
    wide, samples = by_own_residuals(with_disturbances(problem, [one]), q, windows)
    levels = {t.name: t.leading.sigma for t in wide.targets}
    before, after = (float(np.sum(np.square(p.with_sigmas(levels).norms(q, windows)))) for p in (_plain(problem), wide))
    return Score(max(before - after, 0.0), one.dof, 1.0 - after / before if before > 0.0 else 0.0, samples)


def _plain(problem: Problem) -> Problem:
    """Return a problem in which nothing is whitened."""
    return replace(problem, targets=tuple(t.each(lambda c: replace(c, prefilter=None)) for t in problem.targets))


def _followed_coordinates(plain: Problem, q: FloatArray, wide: Problem) -> FloatArray:
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


def count_effective_samples(problem: Problem, q: FloatArray, windows: Windows) -> float:
    """Return the effective samples of the residuals at a point, all channels together."""
    return by_own_residuals(problem, q, windows)[1]


def _least(r: FloatArray, J: FloatArray) -> float:
    """Return the least sum of squares of r + J d."""
    size = np.linalg.norm(J, axis=0)
    size[size == 0.0] = 1.0
    step = np.linalg.lstsq(J / size, -r, rcond=COLLINEAR)[0]
    return float(np.sum((r + (J / size) @ step) ** 2))


def by_own_residuals(problem: Problem, q: FloatArray, windows: Windows) -> tuple[Problem, float]:
    """Return the problem with each channel at its residual's level and effective samples, and the sum of these."""
    total = 0.0

    def one(target: Target) -> Target:
        nonlocal total
        if target.name not in windows:
            return target
        window = windows[target.name]
        channels = []
        for channel, r in zip(target.channels, misfit_series(problem.model, target, q, window), strict=True):
            changed, samples = _by_own_residual(channel, r, window)
            total += samples
            channels.append(changed)
        return replace(target, channels=tuple(channels))

    return replace(problem, targets=tuple(map(one, problem.targets))), total


def _by_own_residual(channel: TargetChannel, r: WritableSeries, window: tuple[int, int]) -> tuple[TargetChannel, float]:
    rejected = channel.rejected_within(window)
    channel.line(r, rejected).subtract_from(r)
    write_at(r, rejected, 0.0)
    counted = max(r.size - rejected.size, 1)
    rms = norm(r) / math.sqrt(counted)
    samples = effective_samples(r) * counted / r.size if rms > 0.0 else float(counted)
    return replace(channel, prefilter=None, sigma=rms * math.sqrt(counted / samples)), samples
