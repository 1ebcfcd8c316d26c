"""Profile likelihood: one parameter held at a sequence of values, all others refitted.

The cost over the held value shows the shape of the likelihood, while the standard error uses only its curvature at the
optimum. The 95 % interval ends where the cost has risen by the 95 % quantile of chi-square with one degree of freedom,
3.84 sigmas squared (Venzon and Moolgavkar 1988). With coloured residuals the cost counts every sample as independent
and rises too fast; the level is then the quantile times the ratio of the robust variance to the white one (Rotnitzky
and Jewell 1990).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.special import chdtri

from mechid.arrays import FloatArray
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.parallel import map_coordinators
from mechid.identification.computation.workforce import working_on
from mechid.identification.output_error.problem import Problem
from mechid.identification.refit.settings import REFIT
from mechid.identification.result.fit import Optimum
from mechid.identification.result.parameter_estimate import ParameterEstimate
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import predicted_reduction, solve
from mechid.identification.stages.freeze import free_only

QUANTILE = float(chdtri(1, 0.05))
"""95 % quantile of chi-square with one degree of freedom."""


class SideEnd(Enum):
    """End of a side of a profile; the value is the sentence for the user."""

    CROSSED = "The cost has risen by its level."
    BOUND = "The bound of the mechanism file comes first."
    CLIFF = "The cost jumps over its level at a stick/slip threshold."
    OPEN = "The cost had not risen by its level when the steps ran out."


@dataclass(frozen=True)
class Point:
    """A held value: the rise of the cost, in sigmas squared, the refitted coordinates, and a note on the refit."""

    value: float
    rise: float
    q: FloatArray
    note: str = ""

    @property
    def root(self) -> float:
        """Square root of the rise; it is linear in the value where the cost is a parabola."""
        return math.sqrt(max(self.rise, 0.0))


@dataclass(frozen=True)
class Cliff:
    """Two neighbouring values between which the cost jumps, and the jump in sigmas squared."""

    below: float
    above: float
    jump: float


@dataclass(frozen=True)
class Profile:
    """The profile of one parameter, in the file's unit.

    Attributes
    ----------
    points : tuple of Point
        In order of value, the estimate among them.
    level, level_coloured : float
        Rises of the cost at which the intervals end, in sigmas squared; the second is None where the residuals
        are white.
    interval, interval_coloured : (float or None, float or None)
        95 % intervals; None on a side that has not reached its level.
    ends : (SideEnd, SideEnd)
        Ends of the sides of `interval`.
    """

    name: str
    unit: str
    value: float
    std_error: float | None
    std_error_white: float | None
    points: tuple[Point, ...]
    level: float
    level_coloured: float | None
    interval: tuple[float | None, float | None]
    interval_coloured: tuple[float | None, float | None]
    ends: tuple[SideEnd, SideEnd]
    cliffs: tuple[Cliff, ...]

    @property
    def gain(self) -> float:
        """Largest fall of a refit below the cost of the estimate, in sigmas squared: 0 at an optimum."""
        return -min(p.rise for p in self.points)


TellPoint = Callable[[str, Point], None]
Refit = Callable[[tuple[str, float, Sequence[FloatArray]]], dict[str, Any]]


def profiles(
    optimum: Optimum,
    names: Sequence[str],
    *,
    workers: int = 1,
    executor: Executor | None = None,
    journal: Journal | None = None,
    on_point: TellPoint = lambda name, point: None,
) -> list[Profile]:
    """Return the profile of each parameter; all sides are computed in parallel.

    The work runs on threads, or on the workers of an executor such as `distributed.Client.get_executor()`.

    Raises
    ------
    UsageError
        If the fit did not estimate a parameter.
    """
    for name in names:
        optimum.estimate_of(name)
    inner = replace(optimum, problem=replace(optimum.problem, workers=1))
    tasks = [(name, sign) for name in names for sign in (-1.0, 1.0)]
    refit = partial(_refit, inner)
    with working_on(executor):
        done = map_coordinators(
            lambda task: _Side(inner, refit, *task, journal or Journal(), on_point).walk(), tasks, workers
        )
    return [_profile(inner, name, done[2 * i], done[2 * i + 1]) for i, name in enumerate(names)]


class _Side:
    """One side of a profile: from the estimate outward, until the cost reaches its level or the steps run out."""

    def __init__(
        self, optimum: Optimum, refit: Refit, name: str, sign: float, journal: Journal, on_point: TellPoint
    ) -> None:
        self.optimum, self.refit, self.name, self.sign = optimum, refit, name, sign
        self.journal, self.on_point = journal, on_point
        self.own = optimum.estimate_of(name)
        self.value = optimum.values(optimum.q)[name]
        self.cliffs: list[Cliff] = []

    def walk(self) -> tuple[list[Point], list[Cliff]]:
        """Compute the points outward from the estimate, and the cliffs between them."""
        _, q = hold_parameter(self.optimum, self.name, self.value)
        points = [Point(self.value, 0.0, q)]
        step, limit = self.sign * self._first_step(), self._limit()
        level = max(_levels(self.own))
        while len(points) < REFIT.most_steps and points[-1].rise < level and points[-1].value != limit:
            value = points[-1].value + step
            value = limit if self.sign * (value - limit) >= 0.0 else value
            point = self._refit_point(value, points)
            before = points[-1].root
            points += [*self._bisect_gap(points, point, REFIT.halvings), point]
            step *= self._growth(before, point)
        return points, self.cliffs

    @staticmethod
    def _growth(before: float, point: Point) -> float:
        """Return the factor on the next step with which the root grows by `REFIT.step`."""
        if point.rise < 0.0:
            return 1.0
        grown = point.root - before
        return min(max(REFIT.step / grown, 0.3), 3.0) if grown > 0.0 else 3.0

    def _first_step(self) -> float:
        """Return the first step, from the standard error, with which the root should grow by `REFIT.step`."""
        error = self.own.std_error_white or self.own.std_error
        return float(REFIT.step * error) if error else 1e-3 * max(abs(self.value), 1e-6)

    def _limit(self) -> float:
        """Return the bound on this side; half a turn away for an angle without bounds."""
        bound = self.own.min if self.sign < 0.0 else self.own.max
        return float(bound) if bound is not None else self.value + self.sign * 180.0

    def _bisect_gap(self, points: Sequence[Point], far: Point, halvings: int) -> list[Point]:
        """Bisect the gap to a further point where the cost may jump, and record the jump as a cliff."""
        near = points[-1]
        # Not (a > b), so that a NaN of a failed refit counts as no jump.
        if not abs(far.root - near.root) > REFIT.jump:
            return []
        if halvings == 0:
            first, second = sorted((near.value, far.value))
            self.cliffs.append(Cliff(first, second, far.rise - near.rise))
            return []
        middle = self._refit_point(0.5 * (near.value + far.value), points)
        inner = self._bisect_gap(points, middle, halvings - 1)
        here = [*points, *inner, middle]
        return [*inner, middle, *self._bisect_gap(here, far, halvings - 1)]

    def _refit_point(self, value: float, points: Sequence[Point]) -> Point:
        """Refit at a held value, from the last point or from the linear extrapolation of the last two."""
        starts = [points[-1].q]
        if len(points) > 1 and points[-1].value != points[-2].value:
            share = (value - points[-1].value) / (points[-1].value - points[-2].value)
            starts.append(points[-1].q + share * (points[-1].q - points[-2].q))
        (found,) = self.journal.map_tasks("profile point", self.refit, [(self.name, value, starts)], 1)
        point = Point(value, found["cost"] - self.optimum.triangle.cost, found["q"], found["note"])
        self.on_point(self.name, point)
        return point


def hold_parameter(optimum: Optimum, name: str, value: float) -> tuple[Problem, FloatArray]:
    """Return the problem with one parameter held at a value, and the point with the others at their optimum."""
    problem, q = optimum.problem, optimum.q
    names = [p.name for p in problem.space.mechanism.free if p.name != name]
    if name in problem.space.mechanism.parameters:
        return free_only(problem, q, names, {name: value})
    at = problem.coordinates.names.index(name)
    targets = tuple(t.fix_parameters({name: value}) for t in problem.targets)
    return replace(problem, targets=targets), np.delete(q, at)


def _refit(optimum: Optimum, task: tuple[str, float, Sequence[FloatArray]]) -> dict[str, object]:
    """Refit all other parameters with one held at a value, from the best of some starts."""
    name, value, starts = task
    problem, q = hold_parameter(optimum, name, value)
    if not problem.size:
        return {"cost": problem.total_norm(q, optimum.windows) ** 2, "q": q, "note": ""}
    inside = [problem.coordinates.clip(q) for q in starts]
    costs = [problem.total_norm(q, optimum.windows) for q in inside]
    solution = solve(problem, inside[int(np.argmin(costs))], optimum.windows)
    note = ""
    if not solution.converged:
        note = "not converged"
    elif predicted_reduction(solution.triangle, ~problem.coordinates.on_bound(solution.q)) > SEARCH.notable_fall:
        note = "stopped at a threshold"
    return {"cost": solution.triangle.cost, "q": solution.q, "note": note}


def _levels(own: ParameterEstimate) -> list[float]:
    """Return the level for white residuals, followed by that for coloured ones where colour counts."""
    error, white = own.std_error, own.std_error_white
    ratio = (error / white) ** 2 if error and white else 1.0
    return [QUANTILE, QUANTILE * ratio] if max(ratio, 1.0 / ratio) > REFIT.coloured else [QUANTILE]


SidePoints = tuple[list[Point], list[Cliff]]


def _profile(optimum: Optimum, name: str, below: SidePoints, above: SidePoints) -> Profile:
    own = optimum.estimate_of(name)
    levels = _levels(own)
    sides = [below, above]
    at = [[_find_crossing(points, cliffs, level) for points, cliffs in sides] for level in levels]
    coloured = at[1] if len(levels) > 1 else [(None, SideEnd.OPEN)] * 2
    return Profile(
        name=name,
        unit=own.unit,
        value=below[0][0].value,
        std_error=own.std_error,
        std_error_white=own.std_error_white,
        points=(*reversed(below[0][1:]), *above[0]),
        level=levels[0],
        level_coloured=levels[1] if len(levels) > 1 else None,
        interval=(at[0][0][0], at[0][1][0]),
        interval_coloured=(coloured[0][0], coloured[1][0]),
        ends=(at[0][0][1], at[0][1][1]),
        cliffs=(*below[1], *above[1]),
    )


def _find_crossing(points: Sequence[Point], cliffs: Sequence[Cliff], level: float) -> tuple[float | None, SideEnd]:
    """Return the value at which a side crosses a level, None if it does not, and the end of the side."""
    i = next((i for i, p in enumerate(points) if p.rise >= level), None)
    if i is None:
        return None, SideEnd.OPEN if len(points) >= REFIT.most_steps else SideEnd.BOUND
    inside, outside = points[i - 1], points[i]
    if any({c.below, c.above} == {inside.value, outside.value} for c in cliffs):
        return inside.value, SideEnd.CLIFF
    # The value is interpolated over the root, in which it is nearly linear; monotone, so it cannot overshoot.
    root = math.sqrt(level)
    roots = np.array([p.root for p in points[: i + 2]])
    values = np.array([p.value for p in points[: i + 2]])
    if np.all(np.diff(roots) > 0.0) and np.all(np.isfinite(roots)):
        return float(PchipInterpolator(roots, values)(root)), SideEnd.CROSSED
    share = (root - inside.root) / (outside.root - inside.root)
    return inside.value + share * (outside.value - inside.value), SideEnd.CROSSED
