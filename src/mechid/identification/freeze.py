"""Freezing of parameters that a dependence ruins: one held, the rest refitted, and what that did to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mechid.campaign import Campaign
from mechid.identification.dependence import Dependence, worst_dependence
from mechid.identification.ending import Frozen
from mechid.identification.problem import Problem
from mechid.identification.reduction import combined
from mechid.identification.space import SearchSpace
from mechid.identification.trail import Trail, joint_fit
from mechid.identification.verdict import seen_coordinates

FloatArray = NDArray[np.float64]


def freeze_dependent(trail: Trail, campaign: Campaign, held: list[Frozen]) -> None:
    """Hold one parameter after another until no dependence ruins an estimate; each is noted in `held`.

    With freezing switched off the first is told and nothing held. A parameter is held at the file's value.
    """
    for _ in campaign.mechanism.free:
        problem, q = trail.problem, trail.q
        triangle = combined(problem.triangles(q, trail.windows))
        if not np.all(np.isfinite(triangle.jacobian)):
            break
        counted = seen_coordinates(problem, triangle) & ~problem.on_bound(q)
        found = worst_dependence(problem, q, triangle, counted, campaign.options)
        if found is None:
            break
        if not campaign.options.freeze:
            trail.warnings.append(f"{found.sentence}; nothing is frozen, as the campaign file wants it")
            break
        held.append(_hold(trail, campaign, found))


def _hold(trail: Trail, campaign: Campaign, found: Dependence) -> Frozen:
    """Refit without the parameter that the dependence gives up."""
    before, was = trail.problem, trail.q
    parameter = campaign.mechanism.parameters[found.held]
    names = [p.name for p in before.space.mechanism.free if p.name != found.held]
    trail.problem, trail.q = without(before, was, names, {found.held: parameter.value})
    joint_fit(trail, f"{found.held} held", tuple(names))
    reason = f"{found.sentence}. Held at {parameter.value:.6g} {parameter.declaration.unit}; "
    return Frozen(found.held, parameter.value, parameter.sigma, reason + _shifts(before, was, trail))


def without(
    problem: Problem, q: FloatArray, free: Sequence[str], values: dict[str, float]
) -> tuple[Problem, FloatArray]:
    """Return the problem, and its point, with only some parameters of the mechanism free, others at `values`."""
    here = problem.space.at(q[: problem.space.size]).with_values(values)
    space = SearchSpace(here.with_free(tuple(free)), problem.space.polar)
    return replace(problem, space=space), np.concatenate([space.start, q[problem.space.size :]])


def _shifts(before: Problem, was: FloatArray, trail: Trail) -> str:
    """Say how far the others have moved by it."""
    old = before.space.values(was[: before.space.size])
    new = trail.problem.space.values(trail.q[: trail.problem.space.size])
    moved = [
        f"{name} by {100.0 * (new[name] / old[name] - 1.0):+.2g} %"
        for name in new
        if name in old and old[name] != 0.0 and abs(new[name] / old[name] - 1.0) > 1e-4
    ]
    return "this moved " + ", ".join(moved) if moved else "no other moved by more than 0.01 %"
