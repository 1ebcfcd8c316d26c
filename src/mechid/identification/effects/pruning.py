"""Backward elimination of groups of coordinates by the derivatives at an optimum, without further fits."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.identification.effects.effect import distance_from_null
from mechid.identification.effects.scores import bayesian_penalty, weight_by_residuals
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle

Groups = Mapping[str, tuple[int, ...]]
"""Coordinates of each group, by name."""


def groups_of(problem: Problem, named: Mapping[str, Collection[str]]) -> Groups:
    """Return the coordinates of groups of dotted names, without groups that have no free parameter."""
    names = problem.coordinates.names
    found = {group: tuple(j for j, name in enumerate(names) if name in own) for group, own in named.items()}
    return {group: places for group, places in found.items() if places}


@dataclass(frozen=True, eq=False)
class Linearisation:
    """Derivatives at an optimum by which its effects are judged, without a further fit.

    Attributes
    ----------
    problem : Problem
        Each channel is weighted by its own residual, because a raised noise level hides which effects are needed.
    q : (n,)
        The optimum.
    triangle : Triangle
    groups : mapping of str to tuple of int
        Coordinates of each effect, by name.
    effective_samples : float
        Effective samples of all records.
    """

    problem: Problem
    q: FloatArray
    triangle: Triangle
    groups: Groups
    effective_samples: float

    @cached_property
    def _null_distances(self) -> FloatArray:
        return distance_from_null(self.problem, self.q)

    @cached_property
    def needed_effects(self) -> frozenset[str]:
        """Effects without which the cost rises by more than k ln N, with the others free to compensate."""
        return frozenset(needed_groups(self.triangle, self._null_distances, self.groups, self.effective_samples))

    def rises(self) -> dict[str, float]:
        """Return the rise of the cost without each effect, and, under an empty name, without all of them."""
        here = _least(self.triangle, self._null_distances, ())
        nulled = {**self.groups, "": _places(self.groups, self.groups)}
        return {name: _least(self.triangle, self._null_distances, places) - here for name, places in nulled.items()}

    def fit_only(self, names: Collection[str]) -> tuple[float, FloatArray]:
        """Return the least cost with only some of the effects, and its point within the bounds, (n,)."""
        places = _places(self.groups, self.groups.keys() - set(names))
        gone, moved, rest = _split(self.triangle, self._null_distances, places)
        step = np.where(gone, -self._null_distances, 0.0)
        step[~gone] = _step(rest, moved)
        return float(np.sum((moved + rest @ step[~gone]) ** 2)), self.problem.coordinates.clip(self.q + step)


def linearise(
    problem: Problem, q: FloatArray, windows: Windows, named: Mapping[str, Collection[str]]
) -> Linearisation | None:
    """Return the derivatives at an optimum by which its effects are judged; None if it cannot be simulated.

    Parameters
    ----------
    problem : Problem
    q : (n,)
    windows : mapping of record to (first, stop)
    named : mapping of str to collection of str
        Dotted names of the coordinates of each effect, by its name.
    """
    weighted, samples = weight_by_residuals(problem, q, windows)
    triangle = weighted.joint(q, windows)
    if not np.all(np.isfinite(triangle.jacobian)):
        return None
    return Linearisation(weighted, q, triangle, groups_of(weighted, named), samples)


def needed_groups(triangle: Triangle, away: FloatArray, groups: Groups, effective_samples: float) -> dict[str, float]:
    """Return the needed groups, each with the rise of the cost without it, with the others free to compensate.

    Groups are dropped backwards, the cheapest first, while dropping costs less than k ln N (Schwarz 1978).

    Parameters
    ----------
    triangle : Triangle
        At an optimum, priors included.
    away : (n,)
        Distance of each coordinate from the null value of its group.
    groups : mapping of str to tuple of int
    effective_samples : float
        N, of all records.
    """
    kept, rises, penalty = dict(groups), {}, bayesian_penalty(effective_samples)
    while kept:
        dropped = _places(groups, groups.keys() - kept.keys())
        here = _least(triangle, away, dropped)
        rises = {name: _least(triangle, away, (*dropped, *places)) - here for name, places in kept.items()}
        excess = {name: rises[name] - len(kept[name]) * penalty for name in kept}
        cheapest = min(excess, key=lambda name: excess[name])
        if excess[cheapest] >= 0.0:
            break
        # One group at a time, because dropping one raises the rises of those that could compensate it.
        del kept[cheapest]
    return {name: rises[name] for name in kept}


def cost_reductions(triangle: Triangle, groups: Groups) -> dict[str, float]:
    """Return the reduction of the cost by each group alone, as predicted by the derivatives.

    All coordinates outside the groups stay free.

    Parameters
    ----------
    triangle : Triangle
        At null values of all groups, priors included.
    groups : mapping of str to tuple of int
    """
    nothing = np.zeros(triangle.jacobian.shape[1])
    alone = _least(triangle, nothing, _places(groups, groups))
    return {name: alone - _least(triangle, nothing, _places(groups, groups.keys() - {name})) for name in groups}


def _places(groups: Groups, names: Iterable[str]) -> tuple[int, ...]:
    return tuple(j for name in names for j in groups[name])


def _least(triangle: Triangle, away: FloatArray, nulled: tuple[int, ...]) -> float:
    """Return the least cost with some coordinates at their null values, as predicted by the derivatives."""
    _, moved, rest = _split(triangle, away, nulled)
    return float(np.sum((moved + rest @ _step(rest, moved)) ** 2))


def _split(triangle: Triangle, away: FloatArray, nulled: tuple[int, ...]) -> tuple[BoolArray, FloatArray, FloatArray]:
    """Return a mask of the nulled coordinates, the residual with them at null, and the derivatives to the others."""
    J, r = triangle.jacobian, triangle.fun
    gone = np.zeros(J.shape[1], dtype=np.bool_)
    gone[list(nulled)] = True
    return gone, r - J[:, gone] @ away[gone], J[:, ~gone]


def _step(J: FloatArray, r: FloatArray) -> FloatArray:
    """Return the step d that minimises r + J d."""
    size = np.linalg.norm(J, axis=0)
    # Columns are scaled to unit length, so that the rank decision does not depend on units.
    size = np.where(size > 0.0, size, 1.0)
    return np.asarray(np.linalg.lstsq(J / size, -r, rcond=1e-12)[0] / size)
