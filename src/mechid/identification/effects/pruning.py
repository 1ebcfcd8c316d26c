"""Backward elimination of groups of coordinates by the derivatives at an optimum: a first pass without any fit."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping

import numpy as np

from mechid.arrays import FloatArray
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


def _places(groups: Groups, names: Iterable[str]) -> tuple[int, ...]:
    return tuple(j for name in names for j in groups[name])


def _least(triangle: Triangle, away: FloatArray, nulled: tuple[int, ...]) -> float:
    """Return the least cost with some coordinates at their null, as the derivatives have it."""
    J, r = triangle.jacobian, triangle.fun
    gone = np.zeros(J.shape[1], dtype=np.bool_)
    gone[list(nulled)] = True
    moved = r - J[:, gone] @ away[gone]
    rest = J[:, ~gone]
    size = np.linalg.norm(rest, axis=0)
    rest = rest / np.where(size > 0.0, size, 1.0)
    step = np.linalg.lstsq(rest, -moved, rcond=1e-12)[0]
    return float(np.sum((moved + rest @ step) ** 2))
