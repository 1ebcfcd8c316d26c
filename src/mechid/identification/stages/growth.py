"""Search from rough starts to the ends of all records: multi-start, gated growth, and the ladder."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.first_moments import run_up
from mechid.identification.search.gates import Growth
from mechid.identification.search.masks import mask_near
from mechid.identification.search.settings import SEARCH
from mechid.identification.stages.effect_rungs import FREED_EFFECTS, FURTHEST, NAMED_EFFECTS
from mechid.identification.stages.kernel_precompilation import LINE
from mechid.identification.stages.ladder import Climb, Rung, climb_ladder
from mechid.identification.stages.masked_growth import MASKED_AS_WRITTEN, MASKED_FURTHEST
from mechid.identification.stages.raised_level import NAMED_AT_RAISED_LEVEL
from mechid.identification.stages.reading_rungs import READINGS
from mechid.identification.stages.settings import STAGES
from mechid.identification.stages.start_growth import grow_from_followed, grow_starts, refine_starts
from mechid.identification.stages.watch import Watch
from mechid.identification.uncertainty.noise import raise_to_residual_levels


def search_growth(
    watch: Watch, state: SearchState, campaign: Campaign, names: tuple[str, ...], seed: int, *, patient: bool = True
) -> tuple[SearchState, Growth | None]:
    """Return the growth from the best starts, or None if no start can be simulated.

    Without `patient`, only the best start is grown, with the mechanism as written or with added effects.
    """
    drawn: list[FloatArray] = []
    found = refine_starts(watch, state, seed, drawn)
    best = next(found, None)
    state = state.at(best.q) if best else state
    state = watch.close(state, "multi-start", names, best.cost if best else math.inf, SEARCH.points)
    if best is None:
        return state, None
    climb = Climb(watch, campaign, seed, state, best, tuple(drawn), found=found)
    if climb.may_add and not climb.is_explained and watch.compile_ahead(climb.families):
        watch.tell("kernels", LINE)
    climb = climb_ladder(climb, LADDER if patient else (*OF_MECHANISM, FURTHEST))
    assert climb.growth is not None, "the mechanism as written is always grown"
    state, growth = replace(climb.state, path=climb.tried), climb.growth
    state = state.at(growth.q, growth.horizons)
    followed = "all records followed to their ends" if growth.complete else "not all records followed"
    if state.before_raised:
        followed += ", noise level raised"
    return watch.close(state, "gated growth", names, math.nan, growth.rounds, followed), growth


def warm_start(state: SearchState, near: Mapping[str, float], seed: int = 0) -> tuple[SearchState, Growth]:
    """Return values close to the optimum as a growth that has reached the ends of all records.

    The values are trusted: a record's residual at them counts as its noise, even if it is coloured, in place of the
    high-frequency floor. Single moments that they do not follow at that floor are masked.
    """
    q = run_up(state.problem, state.problem.coordinates.point(near), known=near)
    problem, q = mask_near(state.problem, q, np.random.default_rng((seed, 0, 7)))
    problem = replace(problem, targets=tuple(raise_to_residual_levels(problem, t, q) for t in problem.targets))
    return state.with_problem(problem), Growth(q, {t.name: t.samples for t in problem.targets}, True, 0)


def _grow_as_written(climb: Climb) -> Climb:
    """Grow the mechanism as written from the best start."""
    watch, state = climb.watch, climb.state
    return replace(
        climb, growth=grow_starts(watch, state, iter([climb.best]), climb.seed, escapes=STAGES.first_escapes)
    )


def _grow_from_followed(climb: Climb) -> Climb:
    """Fit only the records that are followed, and grow all records from there."""
    assert climb.growth is not None
    return replace(climb, growth=grow_from_followed(climb.watch, climb.state, climb.growth, climb.seed))


def _follows_some(climb: Climb) -> bool:
    targets = climb.state.problem.targets
    return climb.growth is not None and any(climb.growth.horizons[t.name] == t.samples for t in targets)


AS_WRITTEN = (
    Rung("as written", lambda climb: True, _grow_as_written),
    Rung("records followed, by themselves", _follows_some, _grow_from_followed),
)
"""Rungs of the mechanism as written."""
OF_MECHANISM = (
    *AS_WRITTEN,
    MASKED_AS_WRITTEN,
    *NAMED_EFFECTS,
    NAMED_AT_RAISED_LEVEL,
    *FREED_EFFECTS,
    MASKED_FURTHEST,
)
"""Rungs with records as declared, at the known noise level."""
LADDER = (*OF_MECHANISM, *READINGS, FURTHEST)
"""All attempts of a search to follow all records to their ends, in order."""
