"""Score test of effects: the share of a model's residual that each would explain, without a fit of its own.

At an optimum, the residual has no component along the free parameters. The part that a further effect would explain
follows from its derivative less the part that the free parameters can imitate (Rao's score test): one pass with
sensitivities for all effects.
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
from mechid.signal.stored_series import WritableSeries, write_at
from mechid.signal.whiteness import effective_samples

SMALLEST = 1e-300
"""Substitute for zero in a quotient; no residual is as small."""
COLLINEAR = 1e-9
"""Relative size below which a direction counts as spanned by others. A choice well above rounding."""

Widen = Callable[[Problem, Sequence[str]], tuple[Problem, FloatArray]]
"""Function that returns a problem with some effects free, and the model's point in it, at their null values."""


def bayesian_penalty(effective_samples: float) -> float:
    """Return the cost of a degree of freedom by the Bayesian criterion, ln N (Schwarz 1978)."""
    return math.log(max(effective_samples, math.e))


@dataclass(frozen=True)
class Score:
    """Reduction of the sum of squares by an effect, using effective sample counts.

    Attributes
    ----------
    chi_square : float
        Reduction of the sum, in variances of the remaining residual.
    dof : int
        Degrees of freedom of the effect.
    share : float
        Share of the sum.
    effective_samples : float
        Effective samples of all records.
    """

    chi_square: float
    dof: int
    share: float
    effective_samples: float

    @property
    def excess(self) -> float:
        """Amount by which it exceeds the cost of its degrees of freedom by the Bayesian criterion, k ln N."""
        return self.chi_square - self.dof * bayesian_penalty(self.effective_samples)


@dataclass(frozen=True, eq=False)
class Landscape:
    """Derivatives at a model's optimum to its free parameters, and to effects that it lacks.

    Attributes
    ----------
    residual : (m,)
    free : (m, n)
        Derivatives to the free parameters.
    effects : mapping of str to (m, k)
        Derivatives to each effect.
    effective_samples : float
        Effective samples of all records.
    failed : tuple of str
        Effects without derivatives, because the simulation with them fails.
    """

    residual: FloatArray
    free: FloatArray
    effects: Mapping[str, FloatArray]
    effective_samples: float
    failed: tuple[str, ...] = ()

    @property
    def too_wide(self) -> tuple[str, ...]:
        """Effects that would free as many parameters as there are effective samples.

        A fit could then explain anything.
        """
        free = self.free.shape[1]
        return tuple(name for name, J in self.effects.items() if free + J.shape[1] >= self.effective_samples)

    def score(self, *names: str) -> Score:
        """Return the joint score of some effects."""
        further = np.column_stack([self.effects[name] for name in names])
        rest = _least(self.residual, self.free)
        fall = max(rest - _least(self.residual, np.column_stack([self.free, further])), 0.0)
        left = max(rest - fall, SMALLEST)  # the noise is estimated from the remaining residual, as in an F test
        return Score(
            self.effective_samples * fall / left, further.shape[1], fall / max(rest, SMALLEST), self.effective_samples
        )

    def scores(self) -> dict[str, Score]:
        """Return the score of each effect on its own."""
        return {name: self.score(name) for name in self.effects if name not in self.too_wide}

    def equivalent_effects(self, name: str) -> Iterator[str]:
        """Yield the effects equivalent to one.

        Each explains as much, and both together no more, so the choice between them remains open.
        """
        own = self.score(name)
        for other in self.effects:
            if other != name:
                both, alone = self.score(name, other), self.score(other)
                if both.excess < own.excess and both.excess < alone.excess:
                    yield other


def landscape_at(
    problem: Problem, q: FloatArray, windows: Windows, effects: Mapping[str, Collection[str]], widen: Widen
) -> Landscape:
    """Return the landscape of a problem at its optimum.

    Each channel is weighted by its residual's own RMS and effective samples: with an incomplete model, the noise level
    would make any effect significant.

    Parameters
    ----------
    problem : Problem
        Without the effects.
    q : (n,)
        Its optimum.
    windows : mapping of record to (first, stop)
    effects : mapping of str to collection of str
        Dotted names of the coordinates of each effect, by its name.
    widen : callable
    """
    plain, samples = weight_by_residuals(problem, q, windows)

    def derivatives(some: Sequence[str]) -> tuple[FloatArray, FloatArray, dict[str, FloatArray]] | None:
        return _derivatives(plain, q, windows, {name: effects[name] for name in some}, widen)

    found, failed = derivatives([*effects]), list[str]()
    if found is None:
        # One failing effect would spoil the common run, so each is then tried alone.
        failed = [name for name in effects if not derivatives([name])]
        found = derivatives([name for name in effects if name not in failed])
    if found is None:
        return Landscape(np.zeros(0), np.zeros((0, 0)), {}, samples, tuple(effects))
    return Landscape(*found, samples, tuple(failed))


def _derivatives(
    plain: Problem, q: FloatArray, windows: Windows, effects: Mapping[str, Collection[str]], widen: Widen
) -> tuple[FloatArray, FloatArray, dict[str, FloatArray]] | None:
    """Return the residual and its derivatives to the free parameters and to some effects.

    None if the simulation fails.
    """
    wide, there = widen(plain, [*effects])
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

    def free_effects(plain: Problem, names: Sequence[str]) -> tuple[Problem, FloatArray]:
        wide = with_disturbances(plain, [own[name] for name in names])
        return wide, transfer_coordinates(plain, q, wide)

    names = {name: [p.name for p in one.parameters] for name, one in own.items()}
    found = landscape_at(problem, q, windows, names, free_effects).scores() if own else {}
    found |= {one.name: _of_lines(problem, q, windows, one) for one in some if one.lines_hz}
    return {one.name: replace(found[one.name], dof=one.dof) for one in some if one.name in found}


def _of_lines(problem: Problem, q: FloatArray, windows: Windows, one: Disturbance) -> Score:
    """Return the score of lines, relative to the residual with them removed.

    Beside strong lines, all other noise is narrow in band. All other parameters stay fixed, so the score is a little
    low.
    """
    wide, samples = weight_by_residuals(with_disturbances(problem, [one]), q, windows)
    levels = {t.name: t.leading.sigma for t in wide.targets}
    before, after = (float(np.sum(np.square(p.with_sigmas(levels).norms(q, windows)))) for p in (_plain(problem), wide))
    return Score(max(before - after, 0.0), one.dof, 1.0 - after / before if before > 0.0 else 0.0, samples)


def _plain(problem: Problem) -> Problem:
    """Return a problem without prefilters."""
    return replace(
        problem, targets=tuple(t.map_channels(lambda c: replace(c, prefilter=None)) for t in problem.targets)
    )


def _followed_coordinates(plain: Problem, q: FloatArray, wide: Problem) -> FloatArray:
    """Return the derivative of a wider problem's coordinates with respect to those of the plain one, (m, n).

    Per-record values that the plain problem lacks follow its mechanism.
    """
    size = plain.space.size
    out = np.zeros((wide.size, plain.size))
    names, slopes = plain.space.value_jacobian(plain.coordinates.of_mechanism(q))
    slope = dict(zip(names, slopes, strict=True))
    rows = {(c.name, c.kind): j for j, c in enumerate(wide.space.coordinates)}
    for i, coordinate in enumerate(plain.space.coordinates):
        out[rows[coordinate.name, coordinate.kind], i] = 1.0
    places = {name: j for j, name in enumerate(plain.coordinates.record_parameter_names, size)}
    for j, c in enumerate(wide.coordinates.own, wide.space.size):
        if c.parameter.name in places:
            out[j, places[c.parameter.name]] = 1.0
        elif c.parameter.replaces in slope:
            out[j, :size] = slope[c.parameter.replaces]
    return out


def count_effective_samples(problem: Problem, q: FloatArray, windows: Windows) -> float:
    """Return the effective samples of the residuals at a point, of all channels together."""
    return weight_by_residuals(problem, q, windows)[1]


def _least(r: FloatArray, J: FloatArray) -> float:
    """Return the least sum of squares of r + J d."""
    size = np.linalg.norm(J, axis=0)
    size[size == 0.0] = 1.0
    step = np.linalg.lstsq(J / size, -r, rcond=COLLINEAR)[0]
    return float(np.sum((r + (J / size) @ step) ** 2))


def weight_by_residuals(problem: Problem, q: FloatArray, windows: Windows) -> tuple[Problem, float]:
    """Return the problem with each channel weighted by its residual and effective samples.

    The sum of the effective samples is returned too.
    """
    total = 0.0

    def one(target: Target) -> Target:
        nonlocal total
        if target.name not in windows:
            return target
        window = windows[target.name]
        channels = []
        for channel, r in zip(target.channels, misfit_series(problem.model, target, q, window), strict=True):
            changed, samples = _weight_by_residual(channel, r, window)
            total += samples
            channels.append(changed)
        return replace(target, channels=tuple(channels))

    return replace(problem, targets=tuple(map(one, problem.targets))), total


def _weight_by_residual(
    channel: TargetChannel, r: WritableSeries, window: tuple[int, int]
) -> tuple[TargetChannel, float]:
    rejected = channel.rejected_within(window)
    channel.line(r, rejected).subtract_from(r)
    write_at(r, rejected, 0.0)
    counted = max(r.size - rejected.size, 1)
    rms = norm(r) / math.sqrt(counted)
    samples = effective_samples(r) * counted / r.size if rms > 0.0 else float(counted)
    # With this sigma the sum of squares equals the effective sample count instead of the sample count.
    return replace(channel, prefilter=None, sigma=rms * math.sqrt(counted / samples)), samples
