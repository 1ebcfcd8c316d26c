"""Profile likelihood: one parameter held at value after value, all others refitted.

The cost over the held value is the likelihood's own shape, where the standard error knows only its curvature at
the optimum. Its 95 % interval ends where the cost has risen by the 95 % quantile of chi-square with one degree of
freedom, 3.84 sigmas squared (Venzon and Moolgavkar 1988). Behind coloured residuals the cost counts every sample
as a new one and rises too fast; there the quantile times the ratio of the robust variance to the white one is
the level (Rotnitzky and Jewell 1990).
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
from mechid.identification.computation.parallel import directed
from mechid.identification.computation.workforce import working_on
from mechid.identification.output_error.problem import Problem
from mechid.identification.refit.settings import REFIT
from mechid.identification.result.fit import Optimum
from mechid.identification.result.parameter_estimate import ParameterEstimate
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import promised_fall, solve
from mechid.identification.stages.freeze import without

QUANTILE = float(chdtri(1, 0.05))
"""Of chi-square of one degree: an interval of 95 %."""


class SideEnd(Enum):
    """How a side of a profile ended; the value is the sentence its reader sees."""

    CROSSED = "The cost has risen by its level."
    BOUND = "The bound of the mechanism file comes first."
    CLIFF = "The cost jumps over its level at a stick/slip threshold."
    OPEN = "The cost had not risen by its level when the steps ran out."


@dataclass(frozen=True)
class Point:
    """A value held: how far the cost has risen, in sigmas squared, where the others went, and how that ended."""

    value: float
    rise: float
    q: FloatArray
    note: str = ""

    @property
    def root(self) -> float:
        """Square root of the rise, which is linear in the value where the cost is a parabola."""
        return math.sqrt(max(self.rise, 0.0))


@dataclass(frozen=True)
class Cliff:
    """Two neighbouring values between which the cost jumps, and by how much, in sigmas squared."""

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
        95 % intervals; None on a side that has not come to its level.
    ends : (SideEnd, SideEnd)
        How the sides of `interval` ended.
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
        """By how much a refit has come below the cost of the estimate, in sigmas squared: 0 at an optimum."""
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
    """Return the profile of each parameter; both sides of all are worked on at once.

    Threads do the work, or the workers of an executor, as `distributed.Client.get_executor()`.

    Raises
    ------
    UsageError
        The fit did not move a parameter.
    """
    for name in names:
        optimum.estimate_of(name)
    inner = replace(optimum, problem=replace(optimum.problem, workers=1))
    tasks = [(name, sign) for name in names for sign in (-1.0, 1.0)]
    refit = partial(_refit, inner)
    with working_on(executor):
        done = directed(
            lambda task: _Side(inner, refit, *task, journal or Journal(), on_point).walked(), tasks, workers
        )
    return [_profile(inner, name, done[2 * i], done[2 * i + 1]) for i, name in enumerate(names)]


class _Side:
    """One side of a profile: from the estimate outward, until the cost has risen by the level or nothing is left."""

    def __init__(
        self, optimum: Optimum, refit: Refit, name: str, sign: float, journal: Journal, on_point: TellPoint
    ) -> None:
        self.optimum, self.refit, self.name, self.sign = optimum, refit, name, sign
        self.journal, self.on_point = journal, on_point
        self.own = optimum.estimate_of(name)
        self.value = optimum.values(optimum.q)[name]
        self.cliffs: list[Cliff] = []

    def walked(self) -> tuple[list[Point], list[Cliff]]:
        """Return the points outward from the estimate, and the cliffs between them."""
        _, q = held(self.optimum, self.name, self.value)
        points = [Point(self.value, 0.0, q)]
        step, limit = self.sign * self._first_step(), self._limit()
        level = max(_levels(self.own))
        while len(points) < REFIT.most_steps and points[-1].rise < level and points[-1].value != limit:
            value = points[-1].value + step
            value = limit if self.sign * (value - limit) >= 0.0 else value
            point = self._refitted(value, points)
            before = points[-1].root
            points += [*self._between(points, point, REFIT.halvings), point]
            step *= self._growth(before, point)
        return points, self.cliffs

    @staticmethod
    def _growth(before: float, point: Point) -> float:
        """Return the factor by which the next step is longer, so that the root grows as wanted."""
        if point.rise < 0.0:
            return 1.0
        grown = point.root - before
        return min(max(REFIT.step / grown, 0.3), 3.0) if grown > 0.0 else 3.0

    def _first_step(self) -> float:
        """Return the step by which the root of the rise should grow as wanted, from the local error."""
        error = self.own.std_error_white or self.own.std_error
        return float(REFIT.step * error) if error else 1e-3 * max(abs(self.value), 1e-6)

    def _limit(self) -> float:
        """Return the bound on this side; of an angle that has none, half a turn away."""
        bound = self.own.min if self.sign < 0.0 else self.own.max
        return float(bound) if bound is not None else self.value + self.sign * 180.0

    def _between(self, points: Sequence[Point], far: Point, halvings: int) -> list[Point]:
        """Return points between the last one and a further one that show whether the cost jumps there."""
        near = points[-1]
        if not abs(far.root - near.root) > REFIT.jump:
            return []
        if halvings == 0:
            first, second = sorted((near.value, far.value))
            self.cliffs.append(Cliff(first, second, far.rise - near.rise))
            return []
        middle = self._refitted(0.5 * (near.value + far.value), points)
        inner = self._between(points, middle, halvings - 1)
        here = [*points, *inner, middle]
        return [*inner, middle, *self._between(here, far, halvings - 1)]

    def _refitted(self, value: float, points: Sequence[Point]) -> Point:
        """Return the point of a held value, refitted from the last one or from where the last two lead."""
        starts = [points[-1].q]
        if len(points) > 1 and points[-1].value != points[-2].value:
            share = (value - points[-1].value) / (points[-1].value - points[-2].value)
            starts.append(points[-1].q + share * (points[-1].q - points[-2].q))
        (found,) = self.journal.mapped("profile point", self.refit, [(self.name, value, starts)], 1)
        point = Point(value, found["cost"] - self.optimum.triangle.cost, found["q"], found["note"])
        self.on_point(self.name, point)
        return point


def held(optimum: Optimum, name: str, value: float) -> tuple[Problem, FloatArray]:
    """Return the problem in which one parameter is known, and its point at the optimum of all others."""
    problem, q = optimum.problem, optimum.q
    names = [p.name for p in problem.space.mechanism.free if p.name != name]
    if name in problem.space.mechanism.parameters:
        return without(problem, q, names, {name: value})
    at = problem.coordinates.names.index(name)
    targets = tuple(t.holding({name: value}) for t in problem.targets)
    return replace(problem, targets=targets), np.delete(q, at)


def _refit(optimum: Optimum, task: tuple[str, float, Sequence[FloatArray]]) -> dict[str, object]:
    """Return the refit of all others where the parameter of a name is held at a value, from the best of some starts."""
    name, value, starts = task
    problem, q = held(optimum, name, value)
    if not problem.size:
        return {"cost": problem.total_norm(q, optimum.windows) ** 2, "q": q, "note": ""}
    inside = [problem.coordinates.clip(q) for q in starts]
    costs = [problem.total_norm(q, optimum.windows) for q in inside]
    solution = solve(problem, inside[int(np.argmin(costs))], optimum.windows)
    note = ""
    if not solution.converged:
        note = "not converged"
    elif promised_fall(solution.triangle, ~problem.coordinates.on_bound(solution.q)) > SEARCH.notable_fall:
        note = "stopped at a threshold"
    return {"cost": solution.triangle.cost, "q": solution.q, "note": note}


def _levels(own: ParameterEstimate) -> list[float]:
    """Return the level of white residuals, and where they are coloured the level of theirs."""
    error, white = own.std_error, own.std_error_white
    ratio = (error / white) ** 2 if error and white else 1.0
    return [QUANTILE, QUANTILE * ratio] if max(ratio, 1.0 / ratio) > REFIT.coloured else [QUANTILE]


Walked = tuple[list[Point], list[Cliff]]


def _profile(optimum: Optimum, name: str, below: Walked, above: Walked) -> Profile:
    own = optimum.estimate_of(name)
    levels = _levels(own)
    sides = [below, above]
    at = [[_crossing(points, cliffs, level) for points, cliffs in sides] for level in levels]
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


def _crossing(points: Sequence[Point], cliffs: Sequence[Cliff], level: float) -> tuple[float | None, SideEnd]:
    """Return where a side rises over a level, and how it ended."""
    i = next((i for i, p in enumerate(points) if p.rise >= level), None)
    if i is None:
        return None, SideEnd.OPEN if len(points) >= REFIT.most_steps else SideEnd.BOUND
    inside, outside = points[i - 1], points[i]
    if any({c.below, c.above} == {inside.value, outside.value} for c in cliffs):
        return inside.value, SideEnd.CLIFF
    root = math.sqrt(level)
    roots = np.array([p.root for p in points[: i + 2]])
    values = np.array([p.value for p in points[: i + 2]])
    if np.all(np.diff(roots) > 0.0) and np.all(np.isfinite(roots)):
        return float(PchipInterpolator(roots, values)(root)), SideEnd.CROSSED
    share = (root - inside.root) / (outside.root - inside.root)
    return inside.value + share * (outside.value - inside.value), SideEnd.CROSSED
