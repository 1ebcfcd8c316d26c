"""Freezing of parameters in a dependence: one is held, the others are refitted, and their shifts are reported."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.result.grade import FitOutcome
from mechid.identification.result.search_state import HeldParameter, SearchState
from mechid.identification.stages.joint_fit import joint_fit
from mechid.identification.stages.watch import Watch
from mechid.identification.uncertainty.dependence import Dependence, worst_dependence
from mechid.identification.uncertainty.verdict import seen_coordinates


def freeze_dependent(watch: Watch, state: SearchState, campaign: Campaign) -> SearchState:
    """Hold one parameter after another at its file value until no dependence ruins an estimate.

    If the campaign disables freezing, the first dependence is reported and nothing is held.
    """
    for _ in campaign.mechanism.free:
        problem, q = state.problem, state.q
        triangle = problem.joint(q, state.windows)
        if not np.all(np.isfinite(triangle.jacobian)):
            break
        counted = seen_coordinates(problem, triangle) & ~problem.coordinates.on_bound(q)
        found = worst_dependence(problem, q, triangle, counted, campaign.options)
        if found is None:
            break
        if not campaign.options.freeze:
            return state.with_warnings(f"{found.sentence}; nothing is frozen, as the campaign file wants it")
        state = _hold_parameter(watch, state, campaign, found, triangle)
    return state


def _hold_parameter(
    watch: Watch, state: SearchState, campaign: Campaign, found: Dependence, triangle: Triangle
) -> SearchState:
    """Refit without the parameter that the dependence selects."""
    before, was = state.problem, state.q
    parameter = campaign.mechanism.parameters[found.held]
    names = [p.name for p in before.space.mechanism.free if p.name != found.held]
    values = _compensate(before, was, triangle, found, parameter.value)
    problem, q = free_only(before, was, names, {**values, found.held: parameter.value})
    state = joint_fit(watch, watch.note(state.with_problem(problem).at(q)), f"{found.held} held", tuple(names))
    if not state.has_converged:
        state = state.with_outcome(FitOutcome.NOT_CONVERGED)
    reason = f"{found.sentence}. Held at {parameter.value:.6g} {parameter.declaration.unit}; "
    seen = seen_coordinates(before, triangle)
    unseen = {name for name, is_seen in zip(before.coordinates.names, seen, strict=True) if not is_seen}
    held = HeldParameter(found.held, parameter.value, parameter.sigma, reason + _shifts(before, was, state, unseen))
    return watch.note(replace(state, frozen=(*state.frozen, held)))


def _compensate(
    problem: Problem, q: FloatArray, triangle: Triangle, found: Dependence, held_at: float
) -> dict[str, float]:
    """Return values of a dependence's other parameters that compensate a change of the held one.

    The changes are powers, which is exact for a product or a ratio. A value that is zero or changes its sign is kept.
    """
    others = [name for name in found.involved if name != found.held]
    now = problem.space.values(q[: problem.space.size])
    if not others or now[found.held] * held_at <= 0.0:
        return {}
    names, slopes = problem.space.value_jacobian(q[: problem.space.size])
    J = triangle.jacobian[:, : problem.space.size] @ np.linalg.pinv(slopes) * [now[n] for n in names]
    # Relative derivatives: the powers that keep the modelled records constant to first order.
    powers = np.linalg.lstsq(J[:, [names.index(n) for n in others]], -J[:, names.index(found.held)], rcond=None)[0]
    limits = problem.space.mechanism.parameters
    moved = {n: now[n] * (held_at / now[found.held]) ** float(k) for n, k in zip(others, powers, strict=True)}
    # A power may lead beyond the bounds of the file.
    return {n: min(max(value, limits[n].min), limits[n].max) for n, value in moved.items()}


def free_only(
    problem: Problem, q: FloatArray, free: Sequence[str], values: dict[str, float]
) -> tuple[Problem, FloatArray]:
    """Return the problem, and its point, with only some parameters of the mechanism free, others at `values`."""
    here = problem.space.at(q[: problem.space.size]).with_values(values)
    space = SearchSpace(here.with_free(tuple(free)), problem.space.polar)
    return replace(problem, space=space), np.concatenate([space.start, q[problem.space.size :]])


def _shifts(before: Problem, was: FloatArray, state: SearchState, unseen: Collection[str]) -> str:
    """Return a sentence about the shifts of the other parameters.

    Parameters that no record determines are left out: they shift only by rounding errors.
    """
    old = before.space.values(was[: before.space.size])
    new = state.problem.space.values(state.q[: state.problem.space.size])
    moved = [
        f"{name} by {100.0 * (new[name] / old[name] - 1.0):+.2g} %"
        for name in new
        if name in old and name not in unseen and old[name] != 0.0 and abs(new[name] / old[name] - 1.0) > 1e-4
    ]
    return "this moved " + ", ".join(moved) if moved else "no other moved by more than 0.01 %"
