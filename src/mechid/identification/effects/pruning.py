"""Backward elimination of groups of coordinates by the derivatives at an optimum: a first pass without any fit."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.identification.effects.effect import distance_from_null
from mechid.identification.effects.scores import by_own_residuals
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle

Groups = Mapping[str, tuple[int, ...]]
"""Coordinates of each group by its name."""


def groups_of(problem: Problem, named: Mapping[str, Collection[str]]) -> Groups:
    """Return the coordinates of groups of dotted names; a group of which none is moved is left out."""
    names = problem.coordinates.names
    found = {group: tuple(j for j, name in enumerate(names) if name in own) for group, own in named.items()}
    return {group: places for group, places in found.items() if places}


def needed_effects(
    problem: Problem, q: FloatArray, windows: Windows, named: Mapping[str, Collection[str]]
) -> frozenset[str]:
    """Return the effects that an optimum needs, as its derivatives have it; all of them where it has none.

    Each channel counts at its residual's own level: a raised noise level hides what is needed.

    Parameters
    ----------
    problem : Problem
    q : (n,)
    windows : mapping of record to (first, stop)
    named : mapping of str to collection of str
        Dotted names of the coordinates of each effect, by its name.
    """
    weighted, worth = by_own_residuals(problem, q, windows)
    triangle = weighted.joint(q, windows)
    if not np.all(np.isfinite(triangle.jacobian)):
        return frozenset(named)
    return frozenset(needed_groups(triangle, distance_from_null(weighted, q), groups_of(weighted, named), worth))


def needed_groups(triangle: Triangle, away: FloatArray, groups: Groups, worth: float) -> dict[str, float]:
    """Return the groups that are needed, each with the rise of the cost without it, others free to make up for it.

    Dropped backwards, the cheapest first, while that costs less than k ln N (Schwarz 1978).

    Parameters
    ----------
    triangle : Triangle
        At an optimum, priors included.
    away : (n,)
        How far each coordinate is from where its group is none.
    groups : mapping of str to tuple of int
    worth : float
        N, how many independent samples the records are worth.
    """
    kept, rises = dict(groups), {}
    while kept:
        dropped = _places(groups, groups.keys() - kept.keys())
        here = _least(triangle, away, dropped)
        rises = {name: _least(triangle, away, (*dropped, *places)) - here for name, places in kept.items()}
        excess = {name: rises[name] - len(kept[name]) * math.log(max(worth, math.e)) for name in kept}
        cheapest = min(excess, key=lambda name: excess[name])
        if excess[cheapest] >= 0.0:
            break
        del kept[cheapest]
    return {name: rises[name] for name in kept}


def rises(triangle: Triangle, away: FloatArray, groups: Groups) -> dict[str, float]:
    """Return the rise of the cost without each group, and under an empty name without all of them, as `needed` does."""
    here = _least(triangle, away, ())
    found = {name: _least(triangle, away, places) - here for name, places in groups.items()}
    return {**found, "": _least(triangle, away, _places(groups, groups)) - here}


def least_without(
    triangle: Triangle, away: FloatArray, groups: Groups, nulled: Iterable[str]
) -> tuple[float, FloatArray]:
    """Return the least cost with some groups at their null, and the step to it, (n,), as the derivatives have it."""
    places = _places(groups, nulled)
    gone, moved, rest = _split(triangle, away, places)
    step = np.where(gone, -away, 0.0)
    step[~gone] = _step(rest, moved)
    return float(np.sum((moved + rest @ step[~gone]) ** 2)), step


def _places(groups: Groups, names: Iterable[str]) -> tuple[int, ...]:
    return tuple(j for name in names for j in groups[name])


def _least(triangle: Triangle, away: FloatArray, nulled: tuple[int, ...]) -> float:
    """Return the least cost with some coordinates at their null, as the derivatives have it."""
    _, moved, rest = _split(triangle, away, nulled)
    return float(np.sum((moved + rest @ _step(rest, moved)) ** 2))


def _split(triangle: Triangle, away: FloatArray, nulled: tuple[int, ...]) -> tuple[BoolArray, FloatArray, FloatArray]:
    """Return which coordinates are nulled, the residual with them there, and the derivatives to the others."""
    J, r = triangle.jacobian, triangle.fun
    gone = np.zeros(J.shape[1], dtype=np.bool_)
    gone[list(nulled)] = True
    return gone, r - J[:, gone] @ away[gone], J[:, ~gone]


def _step(J: FloatArray, r: FloatArray) -> FloatArray:
    """Return the step d that makes r + J d least."""
    size = np.linalg.norm(J, axis=0)
    size = np.where(size > 0.0, size, 1.0)
    return np.asarray(np.linalg.lstsq(J / size, -r, rcond=1e-12)[0] / size)
