"""Check of the declarations before the first stage: warnings, and records read otherwise where that is sure."""

from __future__ import annotations

import os
from dataclasses import replace

from mechid.campaign import Campaign
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.contradiction.confirmed_sight import confirmed_sight
from mechid.identification.contradiction.first_sight_text import first_sight_lines
from mechid.identification.contradiction.own_evidence import hum_lines, own_evidence
from mechid.identification.contradiction.wrong_count import wrong_count_lines
from mechid.identification.output_error.declaration import problem_as_read
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.result.search_state import SearchState


def first_seen(campaign: Campaign, state: SearchState, seed: int) -> tuple[Campaign, SearchState]:
    """Return a campaign with what is to be said first, and a state with its records read as they plainly are.

    With stages of the user's own records are taken as declared.
    """
    sight = confirmed_sight(state.problem, _factors(campaign), seed)
    taken = {} if campaign.stages else sight.sure
    lines = first_sight_lines(campaign, sight, used=not campaign.stages)
    lines += own_evidence(state.problem, sight.doubted)
    lines += [] if lines else wrong_count_lines(state.problem)
    if not lines:
        return campaign, state
    problem = problem_as_read(state.problem, taken)
    state = replace(state, problem=problem, q=problem.start, windows=problem.whole(), taken=taken)
    return replace(campaign, warnings=(*lines, *campaign.warnings)), state


def declaration_warnings(campaign: Campaign) -> tuple[str, ...]:
    """Return a line for each record, or all, that is plainly not as declared, by a model's spectra or by its own."""
    targets = tuple(target_of(record) for record in campaign.estimated if record.data is not None)
    if not campaign.mechanism.free or not targets:
        return ()
    problem = Problem(SearchSpace(campaign.mechanism), targets, workers=os.cpu_count() or 1)
    with one_core_algebra():
        sight = confirmed_sight(problem, _factors(campaign))
        lines = [*first_sight_lines(campaign, sight, used=False), *own_evidence(problem, sight.doubted)]
        lines += [] if lines else wrong_count_lines(problem)
    return (*lines, *hum_lines(targets))


def _factors(campaign: Campaign) -> dict[str, float]:
    """Return what the numbers of each record's leading channel were multiplied by, to be in its SI unit."""
    return {r.name: r.data.channel(r.leading).scale for r in campaign.estimated if r.data is not None}
