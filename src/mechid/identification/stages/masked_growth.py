"""Rungs that mask single windows of misfit, and the lifting of masks that a later fit follows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechid.identification.result.search_state import SearchState
from mechid.identification.search.masks import apply_masks, grow_past_misfit, lift_followed_masks, masked_runs
from mechid.identification.stages.joint_fit import joint_fit
from mechid.identification.stages.ladder import Climb, Rung, furthest_growth
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.term_growth import GrownModel, tell_growth
from mechid.identification.stages.watch import Watch, residual_to_noise


def _mask(climb: Climb) -> Climb:
    """Mask the moment at which the furthest growth has stalled, and continue the growth.

    The rung succeeds if all records are then followed down to their noise. A larger residual shows that something else
    is missing, which masks would hide.
    """
    at, rng = furthest_growth(climb), np.random.default_rng((climb.seed, 0, 7))
    on_progress = tell_growth(climb.watch, at.model)
    found = grow_past_misfit(at.problem, at.growth, rng, on_progress, journal=climb.watch.journal)
    if found is None:
        return climb
    problem, growth = found
    plain = apply_masks(climb.state.problem, masked_runs(problem))
    initial = replace(climb, state=climb.state.with_problem(plain))
    end = initial.with_growth(GrownModel(replace(at.model, problem=problem), growth))
    return end if end.complete and _largest_residual(end) <= STAGES.masked_left else climb


def _largest_residual(climb: Climb) -> float:
    """Return the largest residual-to-noise ratio of a record."""
    state = climb.state
    return max(residual_to_noise(state.problem, state.q, climb.watch.noise.floors).values())


def _has_grown(climb: Climb) -> bool:
    return climb.growth is not None


def _lacks_nothing_at_first(climb: Climb) -> bool:
    """Tell whether the mechanism as written explains the first moments.

    Otherwise, more is missing than a single moment.
    """
    return _has_grown(climb) and climb.is_explained


MASKED_AS_WRITTEN = Rung("as written, single moments left out", _lacks_nothing_at_first, _mask)
MASKED_FURTHEST = Rung("the furthest, single moments left out", _has_grown, _mask)


def fit_followed_again(watch: Watch, state: SearchState, names: tuple[str, ...]) -> SearchState:
    """Refit with the masks lifted of moments that the optimum follows; return the state itself if there are none."""
    problem = lift_followed_masks(state.problem, state.q)
    if problem is state.problem:
        return state
    initial = watch.note(state.with_problem(problem))
    return joint_fit(watch, initial, "moments counted again", names, tolerance=STAGES.rough_tolerance)
